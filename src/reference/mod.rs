//! The slow, independent tracer that the tests compare with.
