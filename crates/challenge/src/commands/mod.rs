//! Arms without recorded efforts: commands and positions of simulated arms behind position controllers, and what the diagnosis
//! makes of them.

pub(crate) mod command_case;
pub(crate) mod command_score;
pub(crate) mod command_series;
