//! Triangles with normals and colours.

use crate::meshes::error::MeshError;
use nalgebra::{Affine3, Matrix3, Point3, Vector3};

/// The colour of surfaces without one: a light grey.
const PLAIN: [f32; 4] = [0.7, 0.7, 0.72, 1.0];

/// Triangles of one colour.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// Corners (m), three a triangle, counter-clockwise seen from outside.
    pub corners: Vec<[f64; 3]>,
    /// Unit normals at the corners.
    pub normals: Vec<[f32; 3]>,
    /// Red, green, blue, opacity in 0..1, if the file gives a colour.
    pub color: Option<[f32; 4]>,
}

/// The surface of a mesh file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Its parts, in the order of the file.
    pub parts: Vec<Part>,
    /// Whether the file puts images on surfaces, which are not read.
    pub has_images: bool,
}

/// The most triangles that are read of one file.
const MOST_TRIANGLES: usize = 4_000_000;

impl Surface {
    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.parts.iter().map(|part| part.corners.len() / 3).sum()
    }

    /// Whether it is not too large.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`].
    pub(crate) fn check_size(&self) -> Result<(), MeshError> {
        if self.triangle_count() > MOST_TRIANGLES { Err(MeshError::TooLarge { most: MOST_TRIANGLES }) } else { Ok(()) }
    }

    /// The surface, if it can be drawn.
    ///
    /// # Errors
    /// [`MeshError::Empty`], [`MeshError::NotFinite`], [`MeshError::TooLarge`].
    pub(crate) fn checked(self) -> Result<Self, MeshError> {
        if self.triangle_count() == 0 {
            return Err(MeshError::Empty);
        }
        let mut coordinates = self.parts.iter().flat_map(|part| part.corners.iter().flatten());
        if !coordinates.all(|coordinate| (*coordinate as f32).is_finite()) {
            return Err(MeshError::NotFinite);
        }
        self.check_size().map(|()| self)
    }

    /// The part of this colour, which is added if it is missing.
    pub(crate) fn part(&mut self, color: Option<[f32; 4]>) -> &mut Part {
        let found = self.parts.iter().position(|part| part.color == color);
        let place = found.unwrap_or_else(|| {
            self.parts.push(Part { color, ..Part::default() });
            self.parts.len() - 1
        });
        &mut self.parts[place]
    }
}

impl Part {
    /// One without triangles and colour, with room for some triangles.
    pub(crate) fn with_room(triangles: usize) -> Self {
        let count = 3 * triangles.min(MOST_TRIANGLES);
        Part { corners: Vec::with_capacity(count), normals: Vec::with_capacity(count), color: None }
    }

    /// Its colour, or else a light grey.
    pub fn shown_color(&self) -> [f32; 4] {
        self.color.unwrap_or(PLAIN)
    }

    /// Adds a polygon by its corners and the normals there, cut into a fan. A missing normal is replaced by the normal of the triangle.
    pub(crate) fn add_polygon(&mut self, corners: &[Corner]) {
        let Some((first, rest)) = corners.split_first() else { return };
        for pair in rest.windows(2) {
            self.add_triangle([first, &pair[0], &pair[1]]);
        }
    }

    /// Adds a triangle.
    pub(crate) fn add_triangle(&mut self, corners: [&Corner; 3]) {
        let [a, b, c] = corners.map(|corner| corner.position.coords);
        let flat = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector3::z);
        for corner in corners {
            let normal = corner.normal.and_then(|normal| normal.try_normalize(0.0)).unwrap_or(flat);
            self.corners.push(corner.position.coords.into());
            self.normals.push(normal.map(|x| x as f32).into());
        }
    }
}

/// A corner of a polygon.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    /// Its place (m).
    pub position: Point3<f64>,
    /// The normal there, of any length.
    pub normal: Option<Vector3<f64>>,
}

/// A placement of polygons that may stretch and mirror.
pub(crate) struct Placement {
    transform: Affine3<f64>,
    /// The transform of normals: the inverse transpose, up to a factor.
    normals: Matrix3<f64>,
    mirrors: bool,
}

impl Placement {
    pub(crate) fn new(transform: Affine3<f64>) -> Self {
        let linear = transform.matrix().fixed_view::<3, 3>(0, 0).into_owned();
        let mirrors = linear.determinant() < 0.0;
        // The matrix of cofactors is the inverse transpose times the determinant, and there is one of every matrix.
        let [x, y, z] = [0, 1, 2].map(|axis| linear.column(axis).into_owned());
        let cofactors = Matrix3::from_columns(&[y.cross(&z), z.cross(&x), x.cross(&y)]);
        Placement { transform, normals: if mirrors { -cofactors } else { cofactors }, mirrors }
    }

    /// Places the corners of a polygon, which stays counter-clockwise seen from outside.
    pub(crate) fn place(&self, corners: &mut [Corner]) {
        for corner in corners.iter_mut() {
            corner.position = self.transform * corner.position;
            corner.normal = corner.normal.map(|normal| self.normals * normal);
        }
        if self.mirrors {
            corners.reverse();
        }
    }
}
