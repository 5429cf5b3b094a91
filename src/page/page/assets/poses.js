// Poses: numbers x, y, z (m), w, x, y, z as matrices, and the motion of all bodies between samples.

// The matrix of a pose.
function poseMatrix(pose) {
  const [x, y, z, qw, qx, qy, qz] = pose;
  const turn = new THREE.Quaternion(qx, qy, qz, qw).normalize();
  return new THREE.Matrix4().compose(new THREE.Vector3(x, y, z), turn, new THREE.Vector3(1, 1, 1));
}

// The index of the last sample at or before a time; times grow.
function sampleBefore(times, time) {
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}

// The recorded motion: times (s) and, for each body, seven columns of numbers.
class Motion {
  constructor(times, poses, bodies) {
    this.times = times;
    this.poses = poses;
    this.bodies = bodies;
    this.last = times.length - 1;
  }

  get end() {
    return this.times[this.last];
  }

  // Puts the pose of every body at a time into its matrix; between samples places lie on lines and turns on arcs.
  place(time, matrices) {
    const before = sampleBefore(this.times, time);
    const after = Math.min(before + 1, this.last);
    const span = this.times[after] - this.times[before];
    const part = span > 0 ? Math.min(1, Math.max(0, (time - this.times[before]) / span)) : 0;
    const samples = this.times.length;
    const one = new THREE.Quaternion();
    const other = new THREE.Quaternion();
    const at = new THREE.Vector3();
    const unit = new THREE.Vector3(1, 1, 1);
    for (let body = 0; body < this.bodies; body++) {
      const number = (k, sample) => this.poses[(7 * body + k) * samples + sample];
      const between = (k) => number(k, before) + part * (number(k, after) - number(k, before));
      at.set(between(0), between(1), between(2));
      one.set(number(4, before), number(5, before), number(6, before), number(3, before));
      other.set(number(4, after), number(5, after), number(6, after), number(3, after));
      matrices[body].compose(at, one.slerp(other, part).normalize(), unit);
    }
  }
}
