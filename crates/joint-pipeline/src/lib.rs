//! Scenes and their composition: from surface and geometry to frequency and damping against amplitude.
