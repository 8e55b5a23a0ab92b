//! What a recipe says, then what it means.
