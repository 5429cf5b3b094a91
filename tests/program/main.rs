//! The program as its users see it: commands, logs, pages, films.

#[path = "../shared/common/mod.rs"]
mod common;

mod accuracy_said;
mod chart;
mod cli;
mod far_springs;
mod film;
mod impacts_kept;
mod inspect;
mod log_options;
mod log_readback;
mod log_safety;
mod model_verb;
mod nonsmooth_report;
mod page;
mod python_readback;
mod redundant;
mod replay;
mod rules;
mod sensitivity_verb;
mod spanning_tree;
mod special_files;
mod stress;
mod sweep;
mod urdf_corpus_runs;
