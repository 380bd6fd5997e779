// Charts of signals and spectra that zoom, drawn by uPlot from the data in the page.
(() => {
  const holder = document.getElementById("zoom");
  const data = JSON.parse(document.getElementById("zoom-data").textContent);
  const windows = [...new Set(data.views.map((view) => view.window).filter(Boolean))];
  const font = "13px system-ui, sans-serif";
  let charts = [];

  function numbers(trace, logarithmic) {
    const bytes = Uint8Array.from(atob(trace.data), (letter) => letter.charCodeAt(0));
    const packed = trace.kind === "f4" ? new Float32Array(bytes.buffer) : new Int16Array(bytes.buffer);
    return Float64Array.from(packed, (value) => (logarithmic ? 10 ** (value * trace.scale) : value * trace.scale));
  }

  function element(kind, inside, parent, text = "") {
    const made = document.createElement(kind);
    Object.assign(made, inside);
    if (text) made.textContent = text;
    parent.append(made);
    return made;
  }

  function choice(label, names, parent) {
    const box = element("label", {}, parent, label + " ");
    const list = element("select", { name: label, onchange: draw }, box);
    names.forEach((name, i) => element("option", { value: i }, list, name));
    return list;
  }

  const controls = element("div", { className: "controls" }, holder);
  const channels = choice("Channel", data.channels.map((channel) => channel.name), controls);
  const chosen = windows.length > 1 ? choice("Window of the spectra", windows, controls) : null;
  const note = element("p", { className: "lead" }, holder);
  const places = data.views.map((view, i) => ({ view, i, box: element("div", { className: "chart" }, holder) }));

  function limits(chart) {
    return [chart.data[0][0], chart.data[0].at(-1)];
  }

  function show(chart, middle, half) {
    const [low, high] = limits(chart);
    const width = Math.min(half, (high - low) / 2);
    const centre = Math.min(Math.max(middle, low + width), high - width);
    chart.setScale("x", { min: centre - width, max: centre + width });
  }

  // A view is moved by shares of its half width and made wider or narrower by a factor.
  function move(chart, by, factor) {
    const { min, max } = chart.scales.x;
    const half = (max - min) / 2;
    show(chart, (min + max) / 2 + by * half, half * factor);
  }

  function buttons(parent, chart) {
    const steps = [
      ["−", "wider", 0, 2],
      ["+", "narrower", 0, 0.5],
      ["◀", "to the left", -1, 1],
      ["▶", "to the right", 1, 1],
      ["all", "the whole", 0, Infinity],
    ];
    for (const [sign, title, by, factor] of steps)
      element("button", { type: "button", title, onclick: () => move(chart, by, factor) }, parent, sign);
  }

  function marked(view) {
    return (chart) => {
      const { ctx, bbox } = chart;
      ctx.save();
      ctx.beginPath();
      ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
      ctx.clip();
      ctx.font = `${13 * devicePixelRatio}px system-ui, sans-serif`;
      ctx.textAlign = "center";
      if (!view.window)
        for (const [name, start, end] of data.windows) {
          const [left, right] = [start, end].map((x) => chart.valToPos(x, "x", true));
          ctx.fillStyle = "rgba(0, 0, 0, 0.05)";
          ctx.fillRect(left, bbox.top, right - left, bbox.height);
          ctx.fillStyle = "#56616b";
          ctx.fillText(name, (left + right) / 2, bbox.top + 14 * devicePixelRatio);
        }
      let free = -Infinity;
      for (const [x, name] of view.marks) {
        const at = Math.round(chart.valToPos(x, "x", true)) + 0.5;
        if (at < bbox.left || at > bbox.left + bbox.width) continue;
        ctx.strokeStyle = "#8a949d";
        ctx.setLineDash([4 * devicePixelRatio, 3 * devicePixelRatio]);
        ctx.beginPath();
        ctx.moveTo(at, bbox.top + 16 * devicePixelRatio);
        ctx.lineTo(at, bbox.top + bbox.height);
        ctx.stroke();
        if (at < free) continue;
        ctx.fillStyle = "#56616b";
        ctx.fillText(name, at, bbox.top + 12 * devicePixelRatio);
        free = at + 1.2 * ctx.measureText(name).width;
      }
      ctx.restore();
    };
  }

  // At most five decades below the largest line, with room for the names of the marks above it.
  function decades(chart, low, high) {
    return high > 0 ? [Math.max(low / 2, high / 1e5), high * 4] : [1e-6, 1];
  }

  function shown(value) {
    return value == null ? "" : Number(value.toPrecision(5)).toString();
  }

  const powersOfTen = {
    splits(chart, axis, low, high) {
      const [first, last] = [Math.ceil(Math.log10(low)), Math.floor(Math.log10(high))];
      return Array.from({ length: last - first + 1 }, (_, i) => 10 ** (first + i));
    },
    values: (chart, ticks) => ticks.map((tick) => `10${String(Math.round(Math.log10(tick))).replace(/./g, raised)}`),
  };

  function raised(sign) {
    return sign === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[sign];
  }

  function made(place) {
    const { view, i, box } = place;
    const traces = data.channels[channels.value].traces[i];
    const x = Float64Array.from({ length: traces.length ? numbers(traces[0]).length : 0 }, (_, k) => {
      return traces[0].start + k * traces[0].step;
    });
    const spread = (chart, low, high) => [low - 0.05 * (high - low), high + 0.12 * (high - low)];
    const options = {
      width: box.clientWidth,
      height: Math.min(260, 0.8 * innerWidth),
      scales: {
        x: { time: false },
        y: { distr: view.logarithmic ? 3 : 1, range: view.logarithmic ? decades : spread },
      },
      axes: [
        { label: view.across, labelSize: 22, size: 34, labelFont: font, font },
        { label: view.up, labelSize: 20, size: 62, labelFont: font, font, ...(view.logarithmic ? powersOfTen : {}) },
      ],
      series: [
        { label: view.across, value: (_, value) => shown(value) },
        ...[...data.runs].reverse().map((run) => ({
          label: run.name,
          stroke: run.colour,
          width: 1,
          points: { show: false },
          value: (_, value) => shown(value),
        })),
      ],
      hooks: { drawClear: [marked(view)] },
    };
    const title = element("h3", {}, box, view.title + (view.window ? `, ${view.window}` : ""));
    const curves = traces.map((trace) => numbers(trace, view.logarithmic));
    const chart = new uPlot(options, [x, ...curves.reverse()], box); // the run of the scene is drawn last, over its control
    buttons(title, chart);
    return chart;
  }

  function draw() {
    for (const chart of charts) chart.destroy();
    charts = [];
    note.textContent = `${data.channels[channels.value].note} Drag across a chart to zoom; double-click to show all of it.`;
    for (const place of places) {
      place.box.replaceChildren();
      if (place.view.window && chosen && place.view.window !== windows[chosen.value]) continue;
      charts.push(made(place));
    }
    holder.charts = charts;
  }

  document.documentElement.classList.add("zooms");
  const folded = holder.closest("details");
  if (folded) folded.addEventListener("toggle", () => folded.open && draw());
  addEventListener("resize", () => {
    for (const chart of charts) chart.setSize({ width: chart.root.parentElement.clientWidth, height: chart.height });
  });
  if (!folded || folded.open) draw();
})();
