//! Limits, dry friction and motors against exact answers, and the laws they obey.

#[path = "../shared/common/mod.rs"]
mod common;

mod closed;
mod contacts;
mod contacts_bowl;
mod contacts_cans;
mod contacts_car;
mod contacts_corners;
mod contacts_cradle;
mod contacts_disc;
mod contacts_dominoes;
mod contacts_falling;
mod contacts_far;
mod contacts_mesh;
mod contacts_orders;
mod contacts_pads;
mod contacts_pairs;
mod contacts_pressed;
mod contacts_rest;
mod contacts_rims;
mod contacts_robot;
mod contacts_rocking;
mod contacts_rocking_cylinder;
mod contacts_rod;
mod contacts_short_steps;
mod contacts_turning;
mod contacts_unsolved;
mod contacts_wall;
mod contacts_wedged;
mod contacts_wobble;
mod continuous;
mod continuous_events;
mod exact;
mod laws;
mod loose;
mod mechanisms;
mod motors;
mod orders;
mod pendulum;
mod reactions;
mod robots;
mod robots_on_floor;
mod slides;
mod throws;
mod toys;
