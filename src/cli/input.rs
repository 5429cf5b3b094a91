//! The options that say what is simulated: shared by every verb that reads a robot.

use catena::model::{Base, Model, ModelOptions, Pose};
use catena::scene::{PackagePath, read_urdf};
use nalgebra::{Rotation3, Translation3, Vector3};
use std::path::{Path, PathBuf};

/// The robot, and where it stands.
#[derive(Clone, Debug, clap::Args)]
pub struct InputArgs {
    /// The robot: a .urdf file
    pub input: PathBuf,

    #[command(flatten)]
    pub world: WorldArgs,
}

/// Where a robot stands, and where its files are.
#[derive(Clone, Debug, clap::Args)]
pub struct WorldArgs {
    /// Whether the root link is fixed in the world or floats freely
    #[arg(long, value_enum, default_value_t = BaseChoice::Fixed)]
    pub base: BaseChoice,

    /// Pose of the root link in the world (m, rad); where it starts if the base floats
    #[arg(long, value_name = "X,Y,Z,ROLL,PITCH,YAW", value_parser = numbers::<6>, default_value = "0,0,0,0,0,0",
          allow_hyphen_values = true, hide_default_value = true)]
    pub base_pose: [f64; 6],

    /// Acceleration of gravity in the world (m/s²)
    #[arg(long, value_name = "X,Y,Z", value_parser = numbers::<3>, default_value = "0,0,-9.81",
          allow_hyphen_values = true)]
    pub gravity: [f64; 3],

    /// Folder of a ROS package, for package://NAME/... (repeatable); then ROS_PACKAGE_PATH, AMENT_PREFIX_PATH and the
    /// folders above the URDF are searched
    #[arg(long, value_name = "NAME=DIR", value_parser = package)]
    pub package: Vec<(String, PathBuf)>,
}

/// `--base`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum BaseChoice {
    /// The root link is fixed in the world
    Fixed,
    /// The root link moves freely
    Floating,
}

impl InputArgs {
    /// Reads and reduces the robot. Every error here is bad input (exit code 2).
    ///
    /// # Errors
    /// What is wrong with the file, naming file, line, and link or joint.
    pub fn load(&self) -> anyhow::Result<Model> {
        self.world.load(&self.input)
    }
}

impl WorldArgs {
    /// The options of the model.
    pub fn model_options(&self) -> ModelOptions {
        let [x, y, z, roll, pitch, yaw] = self.base_pose;
        ModelOptions {
            base: match self.base {
                BaseChoice::Fixed => Base::Fixed,
                BaseChoice::Floating => Base::Floating,
            },
            base_pose: Pose::from_parts(Translation3::new(x, y, z), Rotation3::from_euler_angles(roll, pitch, yaw)),
            gravity: Vector3::from(self.gravity),
        }
    }

    /// Reads and reduces a robot. Every error here is bad input (exit code 2).
    ///
    /// # Errors
    /// What is wrong with the file, naming file, line, and link or joint.
    pub fn load(&self, input: &Path) -> anyhow::Result<Model> {
        let is_scene = input.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
        if is_scene {
            anyhow::bail!("{}: scene files are not read yet; give a .urdf", input.display());
        }
        let packages = PackagePath::from_environment(self.package.clone());
        let robot = read_urdf(input, &packages)?;
        Ok(Model::new(robot, &self.model_options())?)
    }
}

/// Exactly `N` finite numbers, separated by commas.
pub fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let numbers: Vec<f64> = finite_numbers(text)?;
    let count = numbers.len();
    numbers.try_into().map_err(|_| format!("{N} numbers separated by commas are needed, not {count}"))
}

/// Finite numbers, separated by commas.
pub fn finite_numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split(',')
        .map(|word| match word.trim().parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(format!("{word:?} is not a finite number")),
        })
        .collect()
}

/// `NAME=DIR`.
fn package(text: &str) -> Result<(String, PathBuf), String> {
    match text.split_once('=') {
        Some((name, folder)) if !name.is_empty() && !folder.is_empty() => Ok((name.to_string(), folder.into())),
        _ => Err("give NAME=DIR, the name of the package and its folder".to_string()),
    }
}
