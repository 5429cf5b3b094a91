//! The least value of a polynomial through values at the stages of a step.
//!
//! ```text
//!     φ(c) = Σ_i φ_i l_i(c)        c: 0..1, l_i: Lagrange's polynomials of the nodes, from a table of many places
//! ```

/// Places at which the polynomial is looked at before its least value is refined: many more than it has extremes.
const LOOKED_AT: usize = 256;

/// Polynomials through values at nodes between 0 and 1, looked at in many places.
pub(super) struct Looks {
    nodes: Vec<f64>,
    /// l_i of all places, place by place.
    bases: Vec<f64>,
}

impl Looks {
    /// With these nodes.
    pub fn new(nodes: &[f64]) -> Self {
        let nodes = nodes.to_vec();
        let of = |index: usize| bases(&nodes, index as f64 / LOOKED_AT as f64);
        Looks { bases: (0..=LOOKED_AT).flat_map(of).collect(), nodes }
    }

    /// The place and the least value of the polynomial through some values.
    pub fn least(&self, values: &[f64]) -> (f64, f64) {
        let sum = |bases: &[f64]| bases.iter().zip(values).map(|(base, value)| base * value).sum::<f64>();
        let seen: Vec<f64> = self.bases.chunks_exact(values.len()).map(sum).collect();
        let index = (0..seen.len()).min_by(|&one, &other| seen[one].total_cmp(&seen[other])).unwrap_or_default();
        let (best, width) = (index as f64 / LOOKED_AT as f64, 1.0 / LOOKED_AT as f64);
        // The vertex of the parabola through the neighbours.
        let at = |place: f64| sum(&bases(&self.nodes, place));
        let [before, here, after] = [best - width, best, best + width].map(at);
        let bend = before - 2.0 * here + after;
        let place = if bend > 0.0 { best + 0.5 * width * (before - after) / bend } else { best };
        let place = place.clamp(0.0, 1.0);
        (place, at(place).min(here))
    }
}

/// l_i at a place.
fn bases(nodes: &[f64], place: f64) -> Vec<f64> {
    let base = |i: usize| -> f64 {
        let others = (0..nodes.len()).filter(|&other| other != i);
        others.map(|other| (place - nodes[other]) / (nodes[i] - nodes[other])).product()
    };
    (0..nodes.len()).map(base).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_value_of_a_polynomial_through_stages_is_found_to_rounding() {
        let nodes = [0.0, 0.172_673_164_646_011_4, 0.5, 0.827_326_835_353_988_6, 1.0];
        let of = |place: f64| (place - 0.37).powi(2) * (1.0 + place * place) + 1e-9;
        let values = nodes.map(of);
        let (place, least) = Looks::new(&nodes).least(&values);
        // The parabola of three places 1/256 apart is off by the third derivative, 1e-5 of a place, and its square in value.
        assert!((place - 0.37).abs() < 1e-4 && (least - 1e-9).abs() < 1e-9, "{place} {least}");
    }
}
