//! Traction laws of rough and dry-friction contact at points, evaluated in batches with state and consistent tangent.
