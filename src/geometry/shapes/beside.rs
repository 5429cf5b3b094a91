//! The edges and faces at each vertex of a polytope with many vertices.

/// Numbers of edges and faces, vertex after vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Beside {
    edges: Lists,
    faces: Lists,
}

/// A list for each vertex, one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
struct Lists {
    /// Where each begins, and the end of the last.
    starts: Vec<u32>,
    all: Vec<u32>,
}

impl Beside {
    /// For this number of vertices, from the vertices of edges and of faces.
    pub fn new<'c>(
        count: usize,
        edges: impl Iterator<Item = &'c [usize]> + Clone,
        faces: impl Iterator<Item = &'c [usize]> + Clone,
    ) -> Self {
        Beside { edges: Lists::new(count, edges), faces: Lists::new(count, faces) }
    }

    /// The edges of a vertex, in order.
    pub fn edges(&self, vertex: usize) -> &[u32] {
        self.edges.of(vertex)
    }

    /// The faces of a vertex, in order.
    pub fn faces(&self, vertex: usize) -> &[u32] {
        self.faces.of(vertex)
    }
}

impl Lists {
    fn new<'c>(count: usize, corners: impl Iterator<Item = &'c [usize]> + Clone) -> Self {
        let mut starts = vec![0; count + 1];
        corners.clone().flatten().for_each(|&corner| starts[corner + 1] += 1);
        for vertex in 0..count {
            starts[vertex + 1] += starts[vertex];
        }
        let mut places = starts.clone();
        let mut all = vec![0; starts[count] as usize];
        for (number, own) in corners.enumerate() {
            for &corner in own {
                all[places[corner] as usize] = number as u32;
                places[corner] += 1;
            }
        }
        Lists { starts, all }
    }

    fn of(&self, vertex: usize) -> &[u32] {
        &self.all[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}
