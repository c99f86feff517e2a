//! Arms, the errors of their links, and the motions that excite them.

pub(crate) mod bundled;
pub(crate) mod excitation;
pub(crate) mod link_errors;
pub(crate) mod robot;
