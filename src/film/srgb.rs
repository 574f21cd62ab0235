//! The sRGB transfer function at the speed of a table.
