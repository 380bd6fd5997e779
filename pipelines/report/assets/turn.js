// Turns a body of triangles (WebGL 2, flat shading) with labels at places of it.
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const view = document.getElementById("view");
  const canvas = view.querySelector("canvas");
  const gl = canvas.getContext("webgl2");
  if (!gl) {
    view.textContent = "This browser shows no WebGL 2; see the picture beside this page.";
    return;
  }
  const bytes = Uint8Array.from(atob(data.corners), (letter) => letter.charCodeAt(0));
  const [low, high] = data.box;
  const corners = Float32Array.from(new Uint16Array(bytes.buffer), (steps, at) => low[at % 3] + data.step * steps);
  const middle = low.map((value, axis) => (value + high[axis]) / 2);
  const radius = Math.hypot(...low.map((value, axis) => high[axis] - value)) / 2;
  const shader = (kind, text) => {
    const made = gl.createShader(kind);
    gl.shaderSource(made, `#version 300 es\nprecision highp float;\n${text}`);
    gl.compileShader(made);
    return made;
  };
  const program = gl.createProgram();
  gl.attachShader(program, shader(gl.VERTEX_SHADER,
    `in vec3 place; uniform mat3 turn; uniform vec3 middle; uniform vec2 scale; uniform float depth; out vec3 seen;
     void main() { seen = turn * (place - middle); gl_Position = vec4(seen.xy * scale, -seen.z * depth, 1.0); }`));
  gl.attachShader(program, shader(gl.FRAGMENT_SHADER,
    `in vec3 seen; out vec4 colour;
     void main() { vec3 n = normalize(cross(dFdx(seen), dFdy(seen)));
       float light = 0.35 + 0.65 * abs(dot(n, normalize(vec3(0.3, 0.5, 0.8)))); colour = vec4(light * vec3(0.76, 0.8, 0.84), 1.0); }`));
  gl.linkProgram(program);
  gl.useProgram(program);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, corners, gl.STATIC_DRAW);
  const place = gl.getAttribLocation(program, "place");
  gl.enableVertexAttribArray(place);
  gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 0, 0);
  gl.enable(gl.DEPTH_TEST);
  const uniform = (name) => gl.getUniformLocation(program, name);
  const labels = data.labels.map((label) => {
    const made = document.createElement("span");
    made.className = label.seat ? "bore seat" : "bore";
    made.textContent = label.text;
    view.appendChild(made);
    return { made, place: label.place };
  });
  let azimuth = 0.6, height = 0.5, zoom = 0.9;
  const draw = () => {
    const width = view.clientWidth, tall = view.clientHeight, ratio = window.devicePixelRatio || 1;
    canvas.width = width * ratio;
    canvas.height = tall * ratio;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const [ca, sa, ch, sh] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(height), Math.sin(height)];
    const rows = [[ca, sa, 0], [-sa * sh, ca * sh, ch], [sa * ch, -ca * ch, sh]];
    const small = Math.min(width, tall);
    const scale = [(zoom * small) / (width * radius), (zoom * small) / (tall * radius)];
    gl.uniformMatrix3fv(uniform("turn"), false, [0, 1, 2].flatMap((axis) => rows.map((row) => row[axis])));
    gl.uniform3fv(uniform("middle"), middle);
    gl.uniform2fv(uniform("scale"), scale);
    gl.uniform1f(uniform("depth"), 0.5 / radius);
    gl.drawArrays(gl.TRIANGLES, 0, corners.length / 3);
    for (const label of labels) {
      const off = label.place.map((value, axis) => value - middle[axis]);
      const [x, y] = rows.map((row) => row[0] * off[0] + row[1] * off[1] + row[2] * off[2]);
      label.made.style.left = `${(0.5 + 0.5 * x * scale[0]) * width}px`;
      label.made.style.top = `${(0.5 - 0.5 * y * scale[1]) * tall}px`;
    }
  };
  canvas.addEventListener("pointermove", (event) => {
    if (!event.buttons) return;
    azimuth -= event.movementX / 150;
    height = Math.max(-1.57, Math.min(1.57, height + event.movementY / 150));
    draw();
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom *= Math.exp(-event.deltaY / 800);
    draw();
  }, { passive: false });
  window.addEventListener("resize", draw);
  draw();
})();
