//! From files to mechanisms: what is read, what is left out, and that nothing is lost by it.

#[path = "../closed/mod.rs"]
mod closed;
#[path = "../common/mod.rs"]
mod common;
#[path = "../models/mod.rs"]
mod models;

mod islands;
mod lean;
mod model_reduction;
mod robots;
mod scene_file;
mod scenes;
mod urdf_corpus_reading;
mod urdf_reading;
