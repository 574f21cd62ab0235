//! Effects that are means over choices.
