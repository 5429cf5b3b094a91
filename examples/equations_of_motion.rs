//! The equations of motion at one instant: mass matrix, Jacobian, inverse and forward dynamics.
//!
//! `cargo run --release --example equations_of_motion`

use catena::prelude::*;

fn main() -> Result<(), Error> {
    let model = Model::load("robots/arm7.urdf")?;
    let q = [0.0, 0.5, 0.0, -1.0, 0.0, 0.7, 0.0];
    let v = [0.1; 7];
    println!("mass matrix [kg m²]:{:.4}", model.mass_matrix(&q)?);
    println!("velocity of the flange for v [m/s, rad/s]:{:.4}", model.jacobian("flange", &q)?);
    println!("efforts against gravity [N m]:{:.4}", model.gravity_efforts(&q)?);
    let efforts = model.inverse_dynamics(&q, &v, &[1.0; 7])?;
    println!("efforts for 1 rad/s² everywhere [N m]:{efforts:.4}");
    let accelerations = model.forward_dynamics(&q, &v, efforts.as_slice())?;
    println!("and back [rad/s²]:{accelerations:.12}");
    Ok(())
}
