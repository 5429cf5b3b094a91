//! The kinds of scenes. Each takes its numbers from a [`Draw`] alone.

mod balls;
mod carts;
mod edges;
mod heaps;
mod hinges;
mod itself;
mod leaning;
mod locked;
mod loops;
mod robots;
mod stacks;
mod tiles;
mod tossed;
mod trees;

use crate::draw::Draw;
use crate::scene::Scene;

/// Acceleration of gravity (m/s²).
pub const GRAVITY: f64 = 9.81;

type Kind = (&'static str, fn(&mut Draw, Scene) -> Scene);

/// Kinds in the order in which seeds take them; what is most often wrong comes more than once.
const KINDS: [Kind; 20] = [
    ("bounces", balls::bounces),
    ("tossed", tossed::tossed),
    ("settles", hinges::settles),
    ("tree with limits", trees::with_limits),
    ("locked", locked::locked),
    ("loop", loops::four_bar),
    ("slides", balls::slides),
    ("tree on a floor", trees::on_a_floor),
    ("bounces", balls::bounces),
    ("arm", hinges::arm),
    ("two robots", robots::two),
    ("limit", hinges::limit),
    ("cradle", balls::cradle),
    ("followers", locked::followers),
    ("tossed", tossed::tossed),
    ("loop with a held joint", loops::held),
    ("rolls", balls::rolls),
    ("gimbal", trees::gimbal),
    ("stack", stacks::stack),
    ("motors", trees::with_motors),
];

/// The scene of a seed.
pub fn scene(seed: u64) -> Scene {
    let (turn, place) = (seed as usize / KINDS.len(), seed as usize % KINDS.len());
    // Every other tree on a floor is a robot that falls on itself; every other block that slides lands first, one in eight slides off a table, and one in
    // eight turns over its edge; every
    // other ball that rolls is a cart, and one in four a body on tiles; a heap stands for every other stack, a limp robot for one of three pairs of robots, and one with followers for every
    // other chain of them. Two cards that lean on each other stand for every fourth cradle.
    let (kind, make) = match KINDS[place] {
        ("tree on a floor", _) if turn % 2 == 1 => ("robot on itself", itself::robot as fn(&mut Draw, Scene) -> Scene),
        ("slides", _) if turn % 8 == 6 => {
            ("turns over an edge", edges::turns_over_an_edge as fn(&mut Draw, Scene) -> Scene)
        }
        ("slides", _) if turn % 4 == 2 => ("over an edge", edges::over_an_edge as fn(&mut Draw, Scene) -> Scene),
        ("slides", _) if turn % 2 == 1 => ("lands", balls::lands as fn(&mut Draw, Scene) -> Scene),
        ("rolls", _) if turn % 4 == 2 => ("tiles", tiles::tiles as fn(&mut Draw, Scene) -> Scene),
        ("rolls", _) if turn % 2 == 1 => ("cart", carts::cart as fn(&mut Draw, Scene) -> Scene),
        ("stack", _) if turn % 2 == 1 => ("heap", heaps::heap as fn(&mut Draw, Scene) -> Scene),
        ("cradle", _) if turn % 4 == 1 => ("leaning cards", leaning::leaning as fn(&mut Draw, Scene) -> Scene),
        ("followers", _) if turn % 2 == 1 => {
            ("limp with followers", heaps::limp_with_followers as fn(&mut Draw, Scene) -> Scene)
        }
        ("two robots", _) if turn % 3 == 1 => ("limp robot", heaps::limp as fn(&mut Draw, Scene) -> Scene),
        kind => kind,
    };
    let mut draw = Draw::new(seed);
    make(&mut draw, Scene::new(kind, 0.0))
}

/// A heap, a limp robot, or one with followers, in turn.
pub fn crowd(seed: u64) -> Scene {
    let (kind, make) = match seed % 4 {
        0 | 2 => ("heap", heaps::heap as fn(&mut Draw, Scene) -> Scene),
        1 => ("limp with followers", heaps::limp_with_followers as fn(&mut Draw, Scene) -> Scene),
        _ => ("limp robot", heaps::limp as fn(&mut Draw, Scene) -> Scene),
    };
    make(&mut Draw::new(seed), Scene::new(kind, 0.0))
}
