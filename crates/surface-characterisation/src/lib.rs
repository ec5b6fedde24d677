//! From height maps of two faces to asperity populations, gaps and traction laws per interface element.
