// Geometries: meshes of the page with normals that are smooth but for sharp edges, and the primitives of URDF.

// Edges between triangles that are turned by more than this stay sharp: cosine of 40 degrees.
const SHARP = 0.766;

// The geometries of a mesh, one for each colour.
function meshGeometries(bytes, mesh) {
  return mesh.parts.map((part) => {
    const corners = gridPoints(unpackedWords(bytes, part.corners), mesh);
    const triangles = cornerIndices(unpackedWords(bytes, part.triangles));
    return { color: part.color, geometry: creasedGeometry(corners, triangles) };
  });
}

// Corners (m), three numbers each, from three columns of numbers on the grid.
function gridPoints(columns, mesh) {
  const count = columns.length / 3;
  const points = new Float32Array(3 * count);
  for (let axis = 0; axis < 3; axis++) {
    for (let k = 0; k < count; k++) points[3 * k + axis] = mesh.origin[axis] + mesh.step * columns[axis * count + k];
  }
  return points;
}

// Corners of triangles from distances to the newest corner.
function cornerIndices(distances) {
  let newest = 0;
  return distances.map((distance) => {
    const corner = newest - distance;
    if (distance === 0) newest++;
    return corner;
  });
}

// Triangles with a normal at each corner: the mean of the triangles around it that are not turned away too far, by their areas.
function creasedGeometry(points, triangles) {
  const count = triangles.length / 3;
  const faces = new Float32Array(3 * count);
  const areas = new Float32Array(count);
  const around = new Uint32Array(points.length / 3 + 1);
  for (let t = 0; t < count; t++) {
    const a = 3 * triangles[3 * t];
    const b = 3 * triangles[3 * t + 1];
    const c = 3 * triangles[3 * t + 2];
    const ux = points[b] - points[a];
    const uy = points[b + 1] - points[a + 1];
    const uz = points[b + 2] - points[a + 2];
    const vx = points[c] - points[a];
    const vy = points[c + 1] - points[a + 1];
    const vz = points[c + 2] - points[a + 2];
    const nx = uy * vz - uz * vy;
    const ny = uz * vx - ux * vz;
    const nz = ux * vy - uy * vx;
    const area = Math.sqrt(nx * nx + ny * ny + nz * nz);
    areas[t] = area;
    if (area > 0) {
      faces[3 * t] = nx / area;
      faces[3 * t + 1] = ny / area;
      faces[3 * t + 2] = nz / area;
    }
    for (let k = 0; k < 3; k++) around[triangles[3 * t + k] + 1]++;
  }
  for (let k = 1; k < around.length; k++) around[k] += around[k - 1];
  const filled = around.slice();
  const list = new Uint32Array(3 * count);
  for (let k = 0; k < 3 * count; k++) list[filled[triangles[k]]++] = (k / 3) | 0;
  const positions = new Float32Array(9 * count);
  const normals = new Float32Array(9 * count);
  for (let k = 0; k < 3 * count; k++) {
    const own = 3 * ((k / 3) | 0);
    const corner = triangles[k];
    const fx = faces[own];
    const fy = faces[own + 1];
    const fz = faces[own + 2];
    let x = 0;
    let y = 0;
    let z = 0;
    for (let p = around[corner]; p < around[corner + 1]; p++) {
      const t = 3 * list[p];
      if (fx * faces[t] + fy * faces[t + 1] + fz * faces[t + 2] >= SHARP) {
        const area = areas[list[p]];
        x += area * faces[t];
        y += area * faces[t + 1];
        z += area * faces[t + 2];
      }
    }
    const length = Math.sqrt(x * x + y * y + z * z);
    for (let axis = 0; axis < 3; axis++) positions[3 * k + axis] = points[3 * corner + axis];
    normals[3 * k] = length > 0 ? x / length : fx;
    normals[3 * k + 1] = length > 0 ? y / length : fy;
    normals[3 * k + 2] = length > 0 ? z / length : fz;
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(normals, 3));
  return geometry;
}

// The parts of a primitive: one, or of a shape with a seam one for each of its two colours.
function primitiveParts(shape) {
  const geometry = primitiveGeometry(shape);
  if (!shape.seam) return [{ color: null, geometry }];
  const color = shape.color || GREY;
  return [{ color, geometry: quarters(geometry, false) }, { color: seamColor(color), geometry: quarters(geometry, true) }];
}

// The second colour of a shape with a seam: darker, or lighter than a dark one. `film/parts.rs` has the same rule.
function seamColor([red, green, blue, opacity]) {
  const isBright = 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.25;
  const other = (part) => (isBright ? 0.6 * part : part + 0.45 * (1 - part));
  return [other(red), other(green), other(blue), opacity];
}

// The triangles of a shape of revolution in the quarters about z where x y > 0, or in the others.
function quarters(geometry, isDark) {
  const all = geometry.toNonIndexed();
  const places = all.getAttribute("position").array;
  const normals = all.getAttribute("normal").array;
  const chosen = [];
  for (let k = 0; k < places.length; k += 9) {
    const [x, y] = [places[k] + places[k + 3] + places[k + 6], places[k + 1] + places[k + 4] + places[k + 7]];
    if (x * y > 0 === isDark) for (let i = k; i < k + 9; i++) chosen.push(i);
  }
  const part = new THREE.BufferGeometry();
  part.setAttribute("position", new THREE.BufferAttribute(Float32Array.from(chosen, (i) => places[i]), 3));
  part.setAttribute("normal", new THREE.BufferAttribute(Float32Array.from(chosen, (i) => normals[i]), 3));
  return part;
}

// The geometry of a primitive; those of revolution lie along z.
function primitiveGeometry(shape) {
  const [a, b, c] = shape.size;
  const upright = (geometry) => geometry.rotateX(Math.PI / 2);
  switch (shape.kind) {
    case "box": return new THREE.BoxGeometry(a, b, c);
    case "sphere": return new THREE.SphereGeometry(a, 40, 24);
    case "ellipsoid": return new THREE.SphereGeometry(1, 40, 24).scale(a, b, c);
    case "cylinder": return upright(new THREE.CylinderGeometry(a, a, b, 48));
    case "capsule": return upright(new THREE.CapsuleGeometry(a, b, 12, 40));
    default: return new THREE.BufferGeometry();
  }
}
