// Forces as arrows in the world, with colours that tell the sources of forces.js apart.

const ARROW_COLORS = { Reactions: 0xd2352b, Contacts: 0x0a9d63 };

class ArrowLayer {
  // `length` is that of the longest usual arrow (m); `weight` is that of all bodies (N).
  constructor(source, view, length, weight) {
    this.source = source;
    this.view = view;
    this.length = length;
    this.group = new THREE.Group();
    this.group.visible = false;
    view.scene.add(this.group);
    // Arrows inside of links and below floors are seen, too.
    const color = ARROW_COLORS[source.name];
    const material = new THREE.MeshStandardMaterial({ color, emissive: color, emissiveIntensity: 0.35, roughness: 0.6, depthTest: false, transparent: true, opacity: 0.92 });
    const shaft = new THREE.CylinderGeometry(0.015, 0.015, 1, 12).translate(0, 0.5, 0);
    const head = new THREE.ConeGeometry(0.042, 0.12, 16).translate(0, -0.06, 0);
    this.arrows = Array.from({ length: source.most }, () => {
      const [rod, tip] = [new THREE.Mesh(shaft, material), new THREE.Mesh(head, material)];
      const whole = new THREE.Group();
      rod.renderOrder = tip.renderOrder = 3;
      whole.add(rod, tip);
      this.group.add(whole);
      return { whole, rod, tip };
    });
    // Of a body in free fall joints carry roundings only, which are no forces.
    this.usual = Math.max(this.usualForce(), 1e-6 * weight);
  }

  // The force that nine of ten samples with forces do not exceed (N), by the largest of each: impacts do not make all else invisible.
  usualForce() {
    const largest = [];
    const stride = Math.max(1, Math.floor(this.source.samples / 500));
    for (let sample = 0; sample < this.source.samples; sample += stride) {
      const sizes = this.source.forces(sample).map(({ force }) => Math.hypot(...force));
      if (sizes.length > 0) largest.push(Math.max(...sizes.filter(Number.isFinite), 0));
    }
    largest.sort((a, b) => a - b);
    return largest[Math.floor(0.9 * (largest.length - 1))] || 0;
  }

  show(shown) {
    this.group.visible = shown;
    this.view.draw();
  }

  // Draws the forces of a sample; longer ones than three times the usual are cut.
  place(sample) {
    if (!this.group.visible) return;
    const up = new THREE.Vector3(0, 1, 0);
    const forces = this.source.forces(sample);
    this.arrows.forEach(({ whole, rod, tip }, k) => {
      const force = new THREE.Vector3(...(k < forces.length ? forces[k].force : [0, 0, 0]));
      const size = force.length();
      const length = Math.min((size / this.usual) * this.length, 3 * this.length);
      whole.visible = Number.isFinite(length) && length > 0.01 * this.length;
      if (!whole.visible) return;
      const thickness = this.length;
      const head = Math.min(0.12 * thickness, 0.6 * length);
      rod.scale.set(thickness, length - 0.9 * head, thickness);
      tip.scale.set(thickness, head / 0.12, thickness);
      tip.position.set(0, length, 0);
      whole.quaternion.setFromUnitVectors(up, force.divideScalar(size));
      whole.position.set(...forces[k].at);
    });
  }

  // What the arrows mean, in words.
  legend() {
    const { name, meaning, unit } = this.source;
    return `${name}: ${meaning}; an arrow of ${plain(this.length)} m is ${plain(this.usual)} ${unit}, cut at three times that`;
  }
}

// A number in three digits.
function plain(number) {
  if (!Number.isFinite(number)) return "–";
  const size = Math.abs(number);
  if (size === 0) return "0";
  return size >= 1e-3 && size < 1e5 ? String(Number(number.toPrecision(3))) : number.toExponential(2);
}
