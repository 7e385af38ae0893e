'use strict';
// The page of a picture in depth. It draws the view of a camera that moves sideways: of a photo with
// its depth and what is painted behind it, or of the views of a quilt.
(() => {
  const scene = JSON.parse(document.querySelector('main').dataset.scene);
  const stage = document.querySelector('#stage');
  const canvas = document.querySelector('#view');
  const buttons = document.querySelector('#buttons');
  const note = document.querySelector('#note');
  const pictures = [...document.querySelectorAll('img:not(#room)')];
  const isPhoto = scene.kind === 'photo';

  const say = (sentence) => {
    note.textContent = sentence;
    note.hidden = sentence === '';
  };
  const clamp = (value) => Math.min(Math.max(value, -1), 1);

  // ---- Drawing -----------------------------------------------------------------------------------

  const VERTEX = `
    in vec2 corner; // 0..1, from the top left
    out vec2 place;
    uniform mat4 camera;
    uniform vec2 extent; // of the picture in the space of the camera
    void main() {
      place = corner;
      gl_Position = camera * vec4((corner.x - 0.5) * extent.x, (0.5 - corner.y) * extent.y, 0.0, 1.0);
    }`;

  // The photo's surfaces over the background that is painted behind them, as altiro3D's method
  // Layered shows them. Content of column c appears at c - shift * offset(c), where the offset is
  // depth - focus. What is nearer comes from further in the direction of the shift, so a search
  // against this direction meets the nearest first.
  //   surfaces, background: colours
  //   depth: r depth of the surface, g of the background, both 1..255, 0: none; b see below
  //   range: r smallest, g largest depth that can appear in a block
  const PHOTO = `
    in vec2 place;
    uniform sampler2D surfaces;
    uniform sampler2D background;
    uniform sampler2D depth;
    uniform sampler2D range;
    uniform vec2 size;    // px of the textures
    uniform vec4 depths;  // offset of depth 1, of one level, largest step on one surface, px of a block
    uniform float margin; // columns left and right of the picture
    uniform float shift;  // px
    uniform float detail; // level of the smaller textures

    const float NONE = -9.0;
    vec3 colour = vec3(0.0);
    float free = 1.0; // what the search has not covered yet
    vec3 rest = vec3(1e6, 0.0, 0.0); // what ends next to the px: distance, column, layer

    vec3 bytes(sampler2D from, vec2 where) { return floor(look(from, where, 0.0).rgb * 255.0 + 0.5); }
    vec2 offsets(vec2 codes) {
      return mix(depths.x + depths.y * (codes - 1.0), vec2(NONE), vec2(lessThan(codes, vec2(0.5))));
    }
    bool joins(float a, float b) { return a > NONE && b > NONE && abs(a - b) <= depths.z; }

    vec2 at(float column) { return vec2((column + margin + 0.5) / size.x, place.y); }
    void cover(vec4 by, float share) {
      colour += free * share * by.rgb;
      free *= 1.0 - share;
    }

    void main() {
      float picture = size.x - 2.0 * margin;
      float x = place.x * picture - 0.5;
      float row = (min(floor(place.y * size.y), size.y - 1.0) + 0.5) / size.y;
      vec2 block = floor(vec2(x + margin + 0.5, place.y * size.y) / depths.w) + 0.5;
      vec2 limits = offsets(bytes(range, block / ceil(size / depths.w)).rg);
      float way = shift < 0.0 ? -1.0 : 1.0;
      float start = floor(way * (x + shift * limits.y)) + 3.0;
      float count = start - way * (x + shift * limits.x) + 3.0;
      vec2 before = vec2(NONE);
      vec3 beforeBytes = vec3(0.0);
      for (int i = 0; i < STEPS; ++i) {
        if (float(i) > count || free < 0.01) break;
        float column = way * (start - float(i));
        vec3 here = bytes(depth, vec2((column + margin + 0.5) / size.x, row));
        vec2 own = offsets(here.rg);
        vec2 beyond = way * (column - shift * own - x);
        if (own.x > NONE && beyond.x >= 0.0 && beyond.x < rest.x) rest = vec3(beyond.x, column, 0.0);
        if (own.y > NONE && beyond.y >= 0.0 && beyond.y < rest.x) rest = vec3(beyond.y, column, 1.0);
        // a is left of b; each has a surface (x) and a background (y)
        float left = way > 0.0 ? column : column - 1.0;
        vec2 a = way > 0.0 ? own : before;
        vec2 b = way > 0.0 ? before : own;
        // b: 16 * (16 * share of the surface - 1) + end; end 0: the surface goes on to the next
        // column; else the nearer of both reaches (end - 1) / 14 px beyond its px
        float marksA = way > 0.0 ? here.b : beforeBytes.b;
        float marksB = way > 0.0 ? beforeBytes.b : here.b;
        if (i > 0) {
          vec2 atA = left - shift * a;
          vec2 atB = left + 1.0 - shift * b;
          float end = mod(marksA, 16.0);
          float shareA = (floor(marksA / 16.0) + 1.0) / 16.0;
          float shareB = (floor(marksB / 16.0) + 1.0) / 16.0;
          if (a.x > NONE && b.x > NONE && end == 0.0) {
            float part = (x - atA.x) / (atB.x - atA.x);
            if (atA.x <= x && x < atB.x) cover(look(surfaces, at(left + part), detail), mix(shareA, shareB, part));
          } else {
            float reach = 1.0 + max(end - 1.0, 0.0) / 14.0;
            bool goesOn = joins(a.x, b.y);
            bool comes = joins(a.y, b.x);
            if (a.x > NONE && !goesOn && a.x > b.x && atA.x <= x && x < atA.x + reach)
              cover(look(surfaces, at(left), detail), shareA * min(1.0, reach + atA.x - x));
            if (b.x > NONE && !comes && b.x > a.x && atB.x - reach < x && x < atB.x)
              cover(look(surfaces, at(left + 1.0), detail), shareB * min(1.0, reach + x - atB.x));
            float from = goesOn ? atA.x : atA.y;
            float to = comes ? atB.x : atB.y;
            if ((goesOn || comes) && from <= x && x < to)
              cover(look(background, at(left + (x - from) / (to - from)), detail), 1.0);
          }
          if (joins(a.y, b.y) && atA.y <= x && x < atB.y)
            cover(look(background, at(left + (x - atA.y) / (atB.y - atA.y)), detail), 1.0);
        }
        before = own;
        beforeBytes = here;
      }
      // where nothing is painted, what is behind the gap goes on
      if (free > 0.0)
        cover(rest.z > 0.0 ? look(background, at(rest.y), detail) : look(surfaces, at(rest.y), detail), 1.0);
      result = vec4(colour, 1.0);
    }`;

  // Two neighbouring views, blended.
  const VIEWS = `
    in vec2 place;
    uniform sampler2D first;
    uniform sampler2D second;
    uniform vec4 firstTile; // its corner and size in the texture
    uniform vec4 secondTile;
    uniform float part;
    void main() {
      vec4 a = look(first, firstTile.xy + place * firstTile.zw, 0.0);
      vec4 b = look(second, secondTile.xy + place * secondTile.zw, 0.0);
      result = vec4(mix(a.rgb, b.rgb, part), 1.0);
    }`;

  // The shaders are written for WebGL 2; WebGL 1 has other words for the same.
  const isTwo = () => Boolean(window.WebGL2RenderingContext) && gl instanceof WebGL2RenderingContext;
  const FIRST_WORDS = {
    vertex2: '#version 300 es\n',
    fragment2: '#version 300 es\nprecision highp float;\nout vec4 result;\n' +
      'vec4 look(sampler2D from, vec2 at, float detail) { return textureLod(from, at, detail); }\n',
    vertex1: '#define in attribute\n#define out varying\n',
    fragment1: 'precision highp float;\n#define in varying\n#define result gl_FragColor\n' +
      'vec4 look(sampler2D from, vec2 at, float detail) { return texture2D(from, at); }\n',
  };

  let gl = null;
  let program = null;
  let textures = [];
  const uniforms = {};
  const compile = (kind, type, body) => {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, FIRST_WORDS[kind + (isTwo() ? 2 : 1)] + body.replace('STEPS', scene.steps));
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  };

  // @param isExact its numbers are not colours
  const textureOf = (picture, isExact) => {
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, isExact ? gl.NONE : gl.BROWSER_DEFAULT_WEBGL);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, gl.RGB, gl.UNSIGNED_BYTE, picture);
    const shrinks = !isExact && isPhoto && isTwo();
    if (shrinks) gl.generateMipmap(gl.TEXTURE_2D);
    const near = isExact ? gl.NEAREST : gl.LINEAR;
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, shrinks ? gl.LINEAR_MIPMAP_LINEAR : near);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, near);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    return texture;
  };

  // Prepares the drawing. False: this browser cannot draw the picture.
  const prepare = () => {
    const wish = { alpha: false, depth: false, antialias: false, powerPreference: 'low-power' };
    gl = gl || canvas.getContext('webgl2', wish) || canvas.getContext('webgl', wish);
    if (!gl || gl.isContextLost()) return false;
    const precision = gl.getShaderPrecisionFormat(gl.FRAGMENT_SHADER, gl.HIGH_FLOAT);
    const largest = Math.max(...pictures.map((one) => Math.max(one.naturalWidth, one.naturalHeight)));
    if (!precision || precision.precision < 23 || gl.getParameter(gl.MAX_TEXTURE_SIZE) < largest) return false;
    program = gl.createProgram();
    compile('vertex', gl.VERTEX_SHADER, VERTEX);
    compile('fragment', gl.FRAGMENT_SHADER, isPhoto ? PHOTO : VIEWS);
    gl.bindAttribLocation(program, 0, 'corner');
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return false;
    gl.useProgram(program);
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS);
    for (let i = 0; i < count; ++i) {
      const { name } = gl.getActiveUniform(program, i);
      uniforms[name] = gl.getUniformLocation(program, name);
    }
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([0, 0, 1, 0, 0, 1, 1, 1]), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
    textures = pictures.map((one) => textureOf(one, one.hasAttribute('data-exact')));
    if (isPhoto) {
      ['surfaces', 'background', 'depth', 'range'].forEach((name, unit) => {
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, textures[unit]);
        gl.uniform1i(uniforms[name], unit);
      });
      gl.uniform2f(uniforms.size, pictures[2].naturalWidth, pictures[2].naturalHeight);
      gl.uniform4f(uniforms.depths, scene.low, scene.level, scene.tear, scene.block);
      gl.uniform1f(uniforms.margin, scene.margin);
    } else {
      ['first', 'second'].forEach((name, unit) => gl.uniform1i(uniforms[name], unit));
    }
    return gl.getError() === gl.NO_ERROR;
  };

  const useView = (name, unit, view) => {
    const perSheet = scene.columns * scene.rows;
    const sheet = Math.floor(view / perSheet);
    const tile = view % perSheet;
    const [width, height] = [pictures[sheet].naturalWidth, pictures[sheet].naturalHeight];
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, textures[sheet]);
    gl.uniform4f(uniforms[name + 'Tile'], // half a px inside, as neighbours are other views
      ((tile % scene.columns) * scene.width + 0.5) / width,
      (Math.floor(tile / scene.columns) * scene.height + 0.5) / height,
      (scene.width - 1) / width, (scene.height - 1) / height);
  };

  const FLAT = new Float32Array([2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
  // Draws the view from a position, -1 leftmost .. 1 rightmost.
  const draw = (position, camera = FLAT, extent = [1, 1]) => {
    gl.uniformMatrix4fv(uniforms.camera, false, camera);
    gl.uniform2f(uniforms.extent, extent[0], extent[1]);
    if (isPhoto) {
      gl.uniform1f(uniforms.shift, position * scene.reach);
      gl.uniform1f(uniforms.detail, Math.max(0, Math.log2(scene.width / canvas.width)));
    } else {
      const at = (position + 1) / 2 * (scene.views - 1);
      const view = Math.min(Math.floor(at), scene.views - 2);
      useView('first', 0, view);
      useView('second', 1, view + 1);
      gl.uniform1f(uniforms.part, at - view);
    }
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  };

  // Twice the px that the screen shows, which the browser averages, but no more than the picture has.
  let fineness = 2;
  const fitCanvas = () => {
    const box = stage.getBoundingClientRect();
    const wanted = Math.min(box.width, box.height * scene.aspect) * fineness * (window.devicePixelRatio || 1);
    const width = Math.max(1, Math.min(Math.round(wanted), scene.width));
    const height = Math.max(1, Math.round(width / scene.aspect));
    if (canvas.width === width && canvas.height === height) return;
    canvas.width = width;
    canvas.height = height;
    shown = NaN;
  };

  // ---- Motion ------------------------------------------------------------------------------------

  const SECONDS_OF_A_SWAY = 8;
  const SWAY = 0.7; // of the way to the outermost views
  const calm = window.matchMedia('(prefers-reduced-motion: reduce)');
  let sways = !calm.matches;
  let isHeld = false; // by the mouse, a finger or the tilt
  let [position, target, shown, phase] = [0, 0, NaN, 0];
  let [isVisible, runs] = [true, false];
  let frame = 0;
  let lastTime = 0;
  let meanSeconds = 0; // of a frame
  let isInHeadset = false;

  const step = (time) => {
    frame = 0;
    if (!program) return;
    const seconds = Math.min((time - lastTime) / 1000, 0.1);
    lastTime = time;
    if (runs) meanSeconds += (seconds - meanSeconds) * 0.05;
    if (meanSeconds > 0.03 && fineness > 1) { // this computer is slow
      fineness = 1;
      fitCanvas();
    }
    const isSwaying = sways && !isHeld;
    if (isSwaying) {
      phase += seconds * 2 * Math.PI / SECONDS_OF_A_SWAY;
      target = SWAY * Math.sin(phase);
    }
    position += (target - position) * (1 - Math.exp(-seconds / 0.1));
    if (Math.abs(target - position) < 1e-4) position = target;
    if (position !== shown) {
      gl.viewport(0, 0, canvas.width, canvas.height);
      draw(position);
      shown = position;
      canvas.hidden = false;
    }
    runs = isSwaying || position !== target;
    if (runs) wake();
  };
  const wake = () => {
    if (!frame && isVisible && !document.hidden && !isInHeadset && program) frame = requestAnimationFrame(step);
  };
  const moveTo = (to) => {
    target = clamp(to);
    wake();
  };
  const letGo = () => {
    isHeld = false;
    const at = Math.asin(clamp(target / SWAY)); // the own motion goes on where the view is
    phase = Math.cos(phase) < 0 ? Math.PI - at : at;
    wake();
  };
  const setSway = (wanted) => {
    sways = wanted;
    if (motion) motion.setAttribute('aria-pressed', String(sways));
    letGo();
  };

  // "#view=-0.5" shows this view, and does not move by itself.
  const takeAddress = () => {
    const asked = /^#view=(-?[0-9.]+)$/.exec(location.hash);
    if (!asked || !Number.isFinite(Number(asked[1]))) return;
    setSway(false);
    position = clamp(Number(asked[1]));
    moveTo(position);
  };

  const addButton = (text, help, action) => {
    const button = document.createElement('button');
    button.type = 'button';
    button.textContent = text;
    button.title = help;
    button.addEventListener('click', action);
    buttons.append(button);
    return button;
  };
  let motion = null;

  const goFullScreen = () => {
    if (document.fullscreenElement) document.exitFullscreen();
    else stage.requestFullscreen?.().catch(() => {});
  };

  const takeInput = () => {
    let lastX = 0;
    stage.addEventListener('pointermove', (event) => {
      const { left, width } = stage.getBoundingClientRect();
      if (event.pointerType === 'mouse') {
        isHeld = true;
        moveTo(2 * (event.clientX - left) / width - 1);
      } else if (isHeld) {
        moveTo(target - 2 * (event.clientX - lastX) / width);
      }
      lastX = event.clientX;
    });
    stage.addEventListener('pointerdown', (event) => {
      isHeld = true;
      lastX = event.clientX;
    });
    for (const name of ['pointerleave', 'pointercancel']) stage.addEventListener(name, letGo);
    stage.addEventListener('pointerup', (event) => event.pointerType !== 'mouse' && letGo());
    document.addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey) return;
      const ways = { ArrowLeft: -0.1, ArrowRight: 0.1 };
      const isButton = event.target.tagName === 'BUTTON';
      if (event.key in ways) {
        setSway(false);
        moveTo(target + ways[event.key]);
      } else if (event.key === ' ' && !isButton) setSway(!sways);
      else if (event.key === 'f' || event.key === 'F') goFullScreen();
      else return;
      event.preventDefault();
    });
    motion = addButton('Motion', 'Let the picture move by itself, or stop it (Space)', () => setSway(!sways));
    motion.setAttribute('aria-pressed', String(sways));
    calm.addEventListener?.('change', () => setSway(!calm.matches));
    if (document.fullscreenEnabled) addButton('Full screen', 'Fill the screen (F)', goFullScreen);
  };

  // ---- The tilt of a phone -----------------------------------------------------------------------

  const followTilt = () => {
    let middle = null;
    window.addEventListener('deviceorientation', (event) => {
      const angle = screen.orientation ? screen.orientation.angle : 0;
      const tilts = { 0: event.gamma, 90: event.beta, 180: -event.gamma, 270: -event.beta };
      const tilt = event.gamma === null ? null : tilts[angle];
      if (tilt === null || tilt === undefined) return;
      middle = middle === null ? tilt : middle + (tilt - middle) * 0.005; // how the phone is held
      isHeld = true;
      moveTo(-(tilt - middle) / 15);
    });
  };
  const offerTilt = () => {
    const mayAsk = window.isSecureContext && location.protocol !== 'file:' && 'DeviceOrientationEvent' in window;
    if (!mayAsk || !window.matchMedia('(pointer: coarse)').matches) return;
    const button = addButton('Tilt', 'Move the picture by tilting the device', async () => {
      const ask = DeviceOrientationEvent.requestPermission;
      const answer = ask ? await ask.call(DeviceOrientationEvent).catch(() => 'denied') : 'granted';
      button.hidden = true;
      if (answer === 'granted') followTilt();
      else say('The browser does not tell this page how the device is tilted.');
    });
  };

  // ---- Headsets ----------------------------------------------------------------------------------

  const WIDTH = 1.2;    // of the picture in metres,
  const DISTANCE = 1.6; // and how far away it stands

  const enterHeadset = async () => {
    const session = await navigator.xr.requestSession('immersive-vr');
    await gl.makeXRCompatible();
    const layer = new XRWebGLLayer(session, gl, { depth: false });
    session.updateRenderState({ baseLayer: layer });
    const space = await session.requestReferenceSpace('local');
    isInHeadset = true;
    session.addEventListener('end', () => {
      isInHeadset = false;
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      shown = NaN;
      wake();
    });
    const drawEyes = (time, xrFrame) => {
      session.requestAnimationFrame(drawEyes);
      const pose = xrFrame.getViewerPose(space);
      if (!pose) return;
      gl.bindFramebuffer(gl.FRAMEBUFFER, layer.framebuffer);
      gl.clear(gl.COLOR_BUFFER_BIT);
      for (const view of pose.views) {
        const { x, y, width, height } = layer.getViewport(view);
        gl.viewport(x, y, width, height);
        const [p, v] = [view.projectionMatrix, view.transform.inverse.matrix];
        const placed = new Float32Array(v); // the picture stands DISTANCE in front of the start
        for (let i = 0; i < 4; ++i) placed[12 + i] = v[12 + i] - DISTANCE * v[8 + i];
        const camera = new Float32Array(16);
        for (let i = 0; i < 16; ++i)
          for (let k = 0; k < 4; ++k) camera[i] += p[(i % 4) + 4 * k] * placed[(i - i % 4) + k];
        draw(clamp(view.transform.position.x * scene.perMetre), camera, [WIDTH, WIDTH / scene.aspect]);
      }
    };
    session.requestAnimationFrame(drawEyes);
  };
  const offerHeadset = async () => {
    const isThere = await navigator.xr?.isSessionSupported('immersive-vr').catch(() => false);
    if (!isThere) return; // no WebXR, or not in this place
    addButton('Headset', 'Look at the picture in a headset', () =>
      enterHeadset().catch(() => say('The headset cannot be used.')));
  };

  // ---- Start -------------------------------------------------------------------------------------

  // Shows the plain picture. @param why a sentence
  const giveUp = (why) => {
    program = null;
    canvas.hidden = true;
    buttons.hidden = true;
    say(why);
  };
  const tellDamage = () => giveUp('A picture in this page cannot be decoded: the file is damaged. Ask for it again.');

  const start = () => {
    if (pictures.some((one) => one.naturalWidth === 0)) return tellDamage();
    Promise.all(pictures.map((one) => one.decode())).catch(tellDamage); // of pictures that end early
    if (!prepare()) {
      return giveUp('This browser cannot show the picture in depth, as it has no WebGL. This is the picture without depth.');
    }
    new ResizeObserver(() => {
      fitCanvas();
      wake();
    }).observe(stage);
    new IntersectionObserver((entries) => {
      isVisible = entries[entries.length - 1].isIntersecting;
      wake();
    }).observe(stage);
    document.addEventListener('visibilitychange', wake);
    canvas.addEventListener('webglcontextlost', (event) => {
      event.preventDefault();
      program = null;
      canvas.hidden = true; // the plain picture is behind it
    });
    canvas.addEventListener('webglcontextrestored', () => {
      shown = NaN;
      if (prepare()) wake();
    });
    fitCanvas();
    takeInput();
    offerTilt();
    offerHeadset();
    window.addEventListener('hashchange', takeAddress);
    takeAddress();
    wake();
  };
  window.addEventListener('load', start);
})();
