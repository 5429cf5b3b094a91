//! Scene files: text, tables with known keys, readers that resolve their names, [`Scene`](crate::scene::description::Scene).

#[cfg(feature = "scene")]
pub(crate) mod base_velocity;
#[cfg(feature = "scene")]
pub(crate) mod body_reader;
#[cfg(feature = "scene")]
pub(crate) mod body_schema;
#[cfg(feature = "scene")]
pub(crate) mod contact_reader;
#[cfg(feature = "scene")]
pub(crate) mod contact_schema;
#[cfg(feature = "scene")]
pub(crate) mod copies;
#[cfg(feature = "scene")]
pub(crate) mod coupling_reader;
#[cfg(feature = "scene")]
pub(crate) mod joint_reader;
#[cfg(feature = "scene")]
pub(crate) mod joint_schema;
#[cfg(feature = "scene")]
pub(crate) mod load_reader;
#[cfg(feature = "scene")]
pub(crate) mod motion_reader;
#[cfg(not(feature = "scene"))]
pub(crate) mod no_scene_file;
#[cfg(feature = "scene")]
pub(crate) mod relation_reader;
#[cfg(feature = "scene")]
pub(crate) mod rope_reader;
#[cfg(feature = "scene")]
pub(crate) mod scene_file;
pub(crate) mod scene_files;
#[cfg_attr(
    not(feature = "scene"),
    expect(dead_code, reason = "key paths ask only whether a number may be one of these")
)]
pub(crate) mod scene_numbers;
#[cfg(feature = "scene")]
pub(crate) mod scene_schema;
#[cfg(feature = "scene")]
pub(crate) mod target_csv;
#[cfg(feature = "scene")]
pub(crate) mod target_reader;
#[cfg(feature = "scene")]
pub(crate) mod toml_text;
#[cfg(feature = "scene")]
pub(crate) mod winch;
