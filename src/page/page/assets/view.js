// The view in three dimensions: camera, light, grid; drawn when something has changed and not otherwise.

class View {
  constructor(canvas) {
    this.canvas = canvas;
    // Throws where the browser has no WebGL.
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(35, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", () => this.draw());
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0xaab2bc, 2.4));
    const lamp = new THREE.DirectionalLight(0xffffff, 1.9);
    lamp.position.set(-0.6, 0.9, 1);
    this.camera.add(lamp);
    this.scene.add(this.camera);
    this.robot = new THREE.Group();
    this.obstacles = new THREE.Group();
    this.collisions = new THREE.Group();
    this.scene.add(this.robot, this.obstacles, this.collisions);
    this.grid = null;
    // From the robot to the camera, unless the address says otherwise.
    this.side = new THREE.Vector3(1.5, -1.5, 0.85).normalize();
    this.following = null;
    this.waiting = false;
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    // After the materials have their other colours.
    darkness.addEventListener("change", () => this.draw());
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  // Draws before the next picture of the screen.
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.drawNow();
    });
  }

  drawNow() {
    this.renderer.render(this.scene, this.camera);
    document.documentElement.dataset.triangles = this.renderer.info.render.triangles;
  }

  // Looks from this side from now on: three numbers x,y,z to the camera.
  lookFrom(text) {
    const numbers = text.split(",").map(Number);
    if (numbers.length !== 3 || !(Math.hypot(...numbers) > 0)) return;
    // Straight from above, what is up in the picture is not defined; a little beside it is.
    this.side.set(...numbers).normalize();
    if (Math.hypot(this.side.x, this.side.y) < 1e-3) this.side.y -= 1e-3;
  }

  // Looks at a box so that all of it is seen: from the front, the right and above at first.
  look(box) {
    const middle = box.getCenter(new THREE.Vector3());
    const radius = Math.max(0.5 * box.getSize(new THREE.Vector3()).length(), 1e-3);
    const narrow = Math.min(1, this.camera.aspect || 1);
    const distance = (1.02 * radius) / (Math.sin((this.camera.fov * Math.PI) / 360) * narrow);
    this.camera.near = distance / 500;
    this.camera.far = distance * 100;
    this.camera.updateProjectionMatrix();
    this.camera.position.copy(this.side.clone().multiplyScalar(distance).add(middle));
    this.controls.target.copy(middle);
    this.controls.update();
    this.draw();
  }

  // Lets the camera go with a point from now on, or no more if there is none.
  follow(point) {
    if (point && this.following) {
      const moved = point.clone().sub(this.following);
      this.camera.position.add(moved);
      this.controls.target.add(moved);
      this.controls.update();
    }
    this.following = point ? point.clone() : null;
  }

  // A grid in the plane z = 0 of each of these frames, of cells that suit a robot of this size (m); the width of a cell. Because software
  // drawing loses long lines that pass the camera, each side of a cell is a line of its own.
  addGrid(size, planes) {
    const cell = 10 ** Math.round(Math.log10(Math.max(size, 1e-3) / 4));
    const half = Math.min(40, Math.ceil((4 * size) / cell));
    const names = this.obstacles.children.length > 0 ? ["--tile-grid", "--tile-axis"] : ["--grid", "--grid-axis"];
    const lines = (isAxis) => {
      const points = [];
      for (let i = -half; i <= half; i++) {
        if ((i === 0) !== isAxis) continue;
        for (let j = -half; j < half; j++) points.push(i, j, 0, i, j + 1, 0, j, i, 0, j + 1, i, 0);
      }
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points.map((x) => x * cell)), 3));
      return new THREE.LineSegments(geometry, tinted(new THREE.LineBasicMaterial(), names[isAxis ? 1 : 0]));
    };
    this.grid = new THREE.Group();
    for (const plane of planes) {
      for (const drawn of [lines(false), lines(true)]) {
        drawn.matrixAutoUpdate = false;
        drawn.matrix.copy(plane);
        this.grid.add(drawn);
      }
    }
    this.scene.add(this.grid);
    return cell;
  }

  // The place of something in these groups under the pointer, if any.
  hitAt(event, groups) {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const x = (2 * (event.clientX - left)) / width - 1;
    const y = 1 - (2 * (event.clientY - top)) / height;
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2(x, y), this.camera);
    const shown = groups.filter((group) => group.visible);
    return ray.intersectObjects(shown, true).find((found) => found.object.userData.link !== undefined);
  }

  // The link or the obstacle under the pointer, if any.
  linkAt(event) {
    const hit = this.hitAt(event, [this.robot, this.obstacles, this.collisions]);
    return hit ? hit.object.userData.link : null;
  }
}
