// Draws the figures of the page from its data, each when it comes into view, and keeps their time axes synchronised.
"use strict";
(() => {
  const { time, figures } = JSON.parse(document.getElementById("data").textContent);

  // Palette of Okabe and Ito, suitable for colour-blind readers; on a dark background its lighter blue.
  const LIGHT = {
    BLUE: "#0072b2", BAND: "0,114,178", INK: "#1d2730", SOFT: "#5a6772", GRID: "#e9edf0", FINE: "#f3f5f6",
    LINE: "#c6ced4", CARD: "#ffffff", LABEL: "rgba(255,255,255,0.94)",
  };
  const DARK = {
    BLUE: "#56b4e9", BAND: "86,180,233", INK: "#e3e9ee", SOFT: "#a3b0ba", GRID: "#2b353d", FINE: "#222b32",
    LINE: "#47535d", CARD: "#171e24", LABEL: "rgba(30,39,46,0.96)",
  };
  const ORANGE = "#e69f00", GREEN = "#009e73", VERMILION = "#d55e00", PURPLE = "#cc79a7";
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  // On touch screens a swipe scrolls past a figure; with a mouse, dragging zooms.
  const isTouch = window.matchMedia("(pointer: coarse)").matches;
  const REDUCED = window.matchMedia("(max-width: 640px)").matches;
  const line = (color, width, more) => ({ mode: "lines", line: { color, width, ...more } });
  const dots = (color, size, symbol = "circle") =>
    ({ mode: "markers", marker: { color, size, symbol, line: { color, width: symbol === "circle" ? 0 : 1.5 } } });
  // In drawing order. `outlier`: does not widen the view. `range`: name and colour of its band.
  const rolesOn = ({ BLUE, BAND, INK, SOFT }) => { const refused = dots(VERMILION, 7, "x-thin"); return {
    bound: { range: ["±3σ", `rgba(${BAND},0.16)`] },
    interval: { range: ["95 % interval", `rgba(${BAND},0.12)`] },
    raw: { name: "Sample", ...line(BLUE, 1) },
    sensor: { name: "Sensor", outlier: true, ...dots(SOFT, 3) },
    ellipse: { name: "3σ ellipse", outlier: true, ...line(SOFT, 1.2, { dash: "dot" }) },
    reference: { name: "Reference", ...line("rgba(0,158,115,0.6)", 4.5) },
    onboard: { name: "Onboard", outlier: true, ...line(VERMILION, 1.2, { dash: "dash" }) },
    gps: { name: "GPS", ...dots(ORANGE, 4.5) },
    smoothed: { name: "Smoothed", ...line(PURPLE, 1.6) },
    estimate: { name: "Estimate", ...line(BLUE, 1.5), range: ["±3σ", `rgba(${BAND},0.16)`] },
    error: { name: "Error", ...line(BLUE, 1.2) },
    onboard_innovation: { name: "Onboard", outlier: true, ...dots(VERMILION, 3, "circle-open") },
    innovation: { name: "Accepted", ...dots(BLUE, 4) },
    test: { name: "Fix", ...dots(BLUE, 4) },
    mean: { name: "Running mean", ...line(INK, 1.8) },
    reopened: { name: "Filter reset to it", outlier: true, ...dots(PURPLE, 8, "diamond-open") },
    rejected: { name: "Rejected", outlier: true, ...refused },
    test_refused: { name: "Rejected", ...refused },
    gps_rejected: { name: "GPS rejected", outlier: true, ...refused },
    clipped: { name: "Clipped", ...dots(VERMILION, 6, "x-thin") },
    start: { name: "Start", ...dots(INK, 10, "triangle-up") },
    end: { name: "End", ...dots(INK, 9, "square") },
    region: { name: "95 % region", ...line(`rgba(${BAND},0.5)`, 2), fill: "toself", fillcolor: `rgba(${BAND},0.16)` },
    alternative_region: { name: "95 % region", ...line("rgba(230,159,0,0.5)", 2), fill: "toself", fillcolor: "rgba(230,159,0,0.16)" },
    limit: { name: "Limit", ...line(SOFT, 1.2, { dash: "dash" }) },
    first_limit: { name: "Limit", ...line(BLUE, 1.4, { dash: "dash" }) },
    second_limit: { name: "Limit", ...line(ORANGE, 1.4, { dash: "dashdot" }) },
    third_limit: { name: "Limit", ...line(GREEN, 1.4, { dash: "dot" }) },
    input: { name: "Input", ...line(INK, 1.3, { shape: "hv" }) },
    flight: { name: "Flight", ...line("rgba(0,158,115,0.6)", 4.5) },
    residual: { name: "Residual", ...line(BLUE, 1.2) },
    first: { name: "First", ...line(BLUE, 1.5) },
    second: { name: "Second", ...line(ORANGE, 1.5) },
    third: { name: "Third", ...line(GREEN, 1.5) },
    fourth: { name: "Fourth", ...line(PURPLE, 1.5) },
    model: { name: "Model", ...line(BLUE, 1.5) },
    alternative_pole: { name: "Pole of the other model", ...dots(ORANGE, 9, "x-thin") },
    pole: { name: "Pole", ...dots(BLUE, 9, "x-thin") },
  }; };
  let theme = dark.matches ? DARK : LIGHT;
  let ROLES = rolesOn(theme);
  const ORDER = Object.keys(ROLES);

  const isNumber = (value) => value !== null && Number.isFinite(value);
  const limits = ({ y, band }) => {
    if (band?.between) return band.between;
    if (band?.about_zero) return [band.about_zero.map((value) => value && -value), band.about_zero];
    if (!band) return [y, y];
    const side = (sign) => y.map((value, i) => (isNumber(value) ? value + sign * band.around[i] : null));
    return [side(-1), side(1)];
  };

  // Closed outlines, one per uninterrupted span: along the top and back along the bottom.
  const outline = (x, [low, high]) => {
    const [xs, ys] = [[], []];
    for (let start = 0, end = 0; end <= x.length; end++) {
      if (end < x.length && isNumber(x[end])) continue;
      for (let i = start; i < end; i++) { xs.push(x[i]); ys.push(high[i]); }
      for (let i = end - 1; i >= start; i--) { xs.push(x[i]); ys.push(low[i]); }
      xs.push(null); ys.push(null);
      start = end + 1;
    }
    return { x: xs, y: ys };
  };

  const isPlane = ({ abscissa }) => abscissa === "east_m" || Boolean(abscissa.own?.to_scale);

  // Limits without their few widest values. The first fix after an outage can have very wide bounds, which would
  // compress the rest of the plot. The same holds for a band: the uncertainty at the start must not set the scale.
  const most = (values, share) => {
    const sorted = values.filter(isNumber).sort((a, b) => a - b);
    return sorted[Math.floor(share * (sorted.length - 1))];
  };
  const bulk = ({ role, band, y }, lists) => {
    if (band?.around) {
      const widest = Math.min(most(band.around, 0.9) * 1.5, most(band.around, 1));
      const side = (sign) => y.map((value, i) => (isNumber(value) ? value + sign * Math.min(band.around[i], widest) : null));
      return [side(-1), side(1)];
    }
    if (role !== "bound" || !band.about_zero) return lists;
    const widest = most(band.about_zero, 0.97);
    return [[-widest, widest]];
  };

  // The initial range of an axis, with a margin.
  const extent = (lists, { logarithmic } = {}) => {
    let [low, high] = [Infinity, -Infinity];
    for (const list of lists) {
      for (const value of list) {
        if (!isNumber(value) || (logarithmic && value <= 0)) continue;
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    if (low > high) return [0, 1];
    if (logarithmic) [low, high] = [Math.log10(Math.max(low, 1e-3)), Math.log10(high)];
    // A logarithmic axis over a very small range would have no tick labels.
    if (logarithmic && high - low < 0.6) [low, high] = [0.5 * (low + high) - 0.3, 0.5 * (low + high) + 0.3];
    const room = 0.06 * (high - low) || Math.max(Math.abs(high) * 0.1, 0.001);
    return [low - room, high + room];
  };

  // Values that are numbers of modes or counts have integer ticks only.
  const isCount = ({ unit, logarithmic, series }) =>
    unit === "" && !logarithmic && series.every(({ y }) => y.every((value) => !isNumber(value) || Number.isInteger(value)));

  // The initial view of a row and the text above it: its result, and the number of points outside the view.
  const firstView = (row, isOwnPlane) => {
    const inView = row.series.filter(({ role }) => !ROLES[role].outlier);
    const lists = (inView.length ? inView : row.series).flatMap((series) => bulk(series, limits(series)));
    const [lowest, highest] = row.limits ?? [-Infinity, Infinity];
    const [low, high] = extent(lists, row);
    const shown = [Math.max(low, lowest), Math.min(high, highest)];
    const place = row.logarithmic ? Math.log10 : (value) => value;
    const isBeyond = (value) => isNumber(value) && (place(value) < shown[0] || place(value) > shown[1]);
    const beyond = isOwnPlane ? 0 : row.series.reduce((count, { y }) => count + y.filter(isBeyond).length, 0);
    const sign = { good: "✓ ", care: "! ", bad: "✗ " }[row.judged] ?? "";
    const notes = [row.note && sign + row.note, beyond && `${beyond} outlier${beyond === 1 ? "" : "s"} beyond this view: double-click to see all`];
    const color = { good: GREEN, care: "#b06f00", bad: VERMILION }[row.judged] ?? theme.SOFT;
    return { shown, color, text: notes.filter(Boolean).join(" · ") };
  };

  const traces = (row, number, named, figure) => {
    const axes = { xaxis: "x", yaxis: number === 1 ? "y" : `y${number}` };
    const legend = (name) => {
      const isFirst = !named.has(name);
      named.add(name);
      return { name, legendgroup: name, showlegend: isFirst };
    };
    const quantity = row.label.split(",")[0];
    const drawn = [];
    const inOrder = [...row.series].sort((a, b) => ORDER.indexOf(a.role) - ORDER.indexOf(b.role));
    for (const series of inOrder.filter(({ band }) => band)) {
      const [ofRole, fillcolor] = ROLES[series.role].range;
      const name = (series.y.length === 0 && series.name) || ofRole;
      drawn.push({
        type: "scatter", mode: "lines", line: { width: 0 }, fill: "toself", fillcolor, hoverinfo: "skip",
        ...outline(series.x, limits(series)), ...axes, ...legend(name),
      });
    }
    for (const series of inOrder.filter(({ y }) => y.length > 0)) {
      const { name: ofRole, range, outlier, ...style } = ROLES[series.role];
      const name = series.name ?? ofRole;
      if (style.line && series.y.length === 1) Object.assign(style, dots(style.line.color, 6));
      const isTimed = figure.abscissa === "east_m" && series.role === "estimate" && series.time;
      const shade = series.shade ?? (isTimed && { values: series.time, label: "s" });
      if (shade) {
        style.mode = "lines+markers";
        style.line = { ...style.line, width: 1 };
        style.marker = {
          size: 4, color: shade.values, colorscale: "Viridis",
          colorbar: { title: { text: shade.label, side: "top" }, thickness: 10, len: 0.6, x: 1.01, tickfont: { size: 11 } },
        };
      }
      const half = series.band?.around;
      const spread = half ? " ± %{customdata:.3~g}" : "";
      const unit = row.unit === "" || row.unit === "°" ? row.unit : ` ${row.unit}`;
      drawn.push({
        type: "scatter", ...style, x: series.x, y: series.y,
        customdata: half ?? series.time ?? [],
        hovertemplate: figure.abscissa === "east_m"
          ? `%{y:.2f} m north, %{x:.2f} m east${series.time ? "<br>at %{customdata:.2f} s" : ""}<extra>${name}</extra>`
          : isPlane(figure)
          ? `%{x:.4~g}, %{y:.4~g}${unit}<extra>${name}</extra>`
          : `%{y:.4~g}${spread}${unit} <i>${quantity} ${name.toLowerCase().replace("gps", "GPS")}</i><extra></extra>`,
        ...axes, ...legend(name),
      });
    }
    return drawn;
  };

  // On a phone, the legend has three lines of space below the buttons.
  const SIDE = REDUCED ? { left: 62, right: 8, top: 112, bottom: 44 } : { left: 84, right: 14, top: 36, bottom: 46 };
  const NOTE = 18;
  const axisOn = ({ GRID, LINE }) => ({ gridcolor: GRID, linecolor: LINE, zerolinecolor: LINE, ticks: "outside", tickcolor: LINE, ticklen: 4 });

  const [first, last] = time?.span ?? [0, 1];
  const whole = last > first ? [first, last] : [first - 1, last + 1];

  // The initial range of a figure's own axis: its limits, or all data, with a margin in a plane.
  const reach = ({ abscissa: { own }, rows }) => {
    const place = own.logarithmic ? Math.log10 : (value) => value;
    if (own.limits) return own.limits.map(place);
    const xs = rows.flatMap(({ series }) => series.map(({ x }) => x));
    if (own.to_scale) return extent(xs);
    const known = xs.flat().filter((value) => isNumber(value) && (!own.logarithmic || value > 0));
    const [low, high] = [Math.min, Math.max].map((pick) => place(known.reduce((a, b) => pick(a, b))));
    return high > low ? [low, high] : [low - 1, high + 1];
  };

  // Over fewer than two decades, an axis with decade ticks only would have too few labels.
  const logarithmicAxis = ([from, to]) => ({
    // Full numbers, such as 0.2 instead of 2.
    type: "log", dtick: to - from < 2 ? "D2" : 1, tickformat: "~g",
    minor: { ticks: "outside", dtick: "D1", ticklen: 2, showgrid: true, gridcolor: theme.FINE },
  });

  const describe = (figure, height) => {
    const axis = axisOn(theme);
    const isMap = isPlane(figure);
    const own = figure.abscissa.own;
    const data = [], annotations = [], shapes = [], named = new Set();
    const count = figure.rows.length;
    const views = figure.rows.map((row) => firstView(row, Boolean(own?.to_scale)));
    const room = views.some(({ text }) => text) ? NOTE : 0;
    const plotHeight = height - SIDE.top - room - SIDE.bottom;
    const gap = (10 + room) / plotHeight;
    const share = (1 - gap * (count - 1)) / count;
    const layout = {
      height, annotations, shapes,
      margin: { l: SIDE.left, r: SIDE.right, t: SIDE.top + room, b: SIDE.bottom },
      font: { family: getComputedStyle(document.body).fontFamily, size: 13, color: theme.INK },
      paper_bgcolor: theme.CARD, plot_bgcolor: theme.CARD, dragmode: isTouch ? false : "zoom",
      hovermode: isMap ? "closest" : "x unified",
      hoversubplots: "axis", hoverdistance: 6,
      hoverlabel: { bgcolor: theme.LABEL, bordercolor: theme.LINE, font: { size: 12, color: theme.INK } },
      legend: { orientation: "h", x: 0, xanchor: "left", y: 1 + (4 + room) / plotHeight, yanchor: "bottom", itemsizing: "constant", font: { size: REDUCED ? 11 : 13 } },
      xaxis: {
        ...axis, title: { text: own?.label ?? (isMap ? "East, m" : time.label), standoff: 8 },
        anchor: count > 1 ? `y${count}` : "y", range: own ? reach(figure) : [...whole], exponentformat: "none",
        ...(own?.logarithmic ? logarithmicAxis(reach(figure)) : {}),
        ...(isMap ? {} : { showspikes: true, spikemode: "across", spikethickness: 1, spikedash: "solid", spikecolor: "#9aa5ae", hoverformat: own ? ".4~g" : ".2f" }),
      },
    };
    figure.rows.forEach((row, index) => {
      const number = index + 1;
      const { shown, text, color } = views[index];
      const top = 1 - index * (share + gap);
      data.push(...traces(row, number, named, figure));
      layout[number === 1 ? "yaxis" : `yaxis${number}`] = {
        ...axis, title: { text: row.label.length > 14 ? row.label.replace(" ", "<br>") : row.label, standoff: 6 },
        domain: [Math.max(0, top - share), top],
        range: row.reversed ? [...shown].reverse() : shown,
        type: row.logarithmic ? "log" : "linear",
        nticks: isMap ? undefined : 6,
        ...(row.logarithmic ? { dtick: shown[1] - shown[0] < 1.5 ? "D2" : 1, tickformat: "~g" } : {}),
        ...(isCount(row) ? { dtick: Math.ceil((shown[1] - shown[0]) / 6), tickformat: "d" } : {}),
        ...(isMap ? { scaleanchor: "x", scaleratio: 1 } : {}),
      };
      if (text) {
        annotations.push({
          text, showarrow: false, xref: "paper", x: 1, xanchor: "right",
          yref: "paper", y: top, yanchor: "bottom", font: { size: REDUCED ? 10 : 12, color },
        });
      }
    });
    if (figure.abscissa === "east_m") {
      const tracks = figure.rows[0].series.filter(({ role }) => !ROLES[role].outlier);
      layout.xaxis.range = extent((tracks.length ? tracks : figure.rows[0].series).map(({ x }) => x));
    } else if (!own) {
      for (const [x0, x1] of time.outages) {
        shapes.push({ type: "rect", layer: "below", xref: "x", yref: "paper", x0, x1, y0: 0, y1: 1, fillcolor: "rgba(90,103,114,0.13)", line: { width: 0 } });
      }
      // A finding: its span is shaded over the full height, with a sign at the bottom whose hover text describes it.
      for (const { span: [x0, x1], words } of time.marks) {
        // A finding over nearly the whole time is not shaded.
        if (x1 - x0 > 0.8 * (whole[1] - whole[0])) continue;
        shapes.push({ type: "rect", layer: "below", xref: "x", yref: "paper", x0, x1: Math.max(x1, x0 + 1e-3), y0: 0, y1: 1, fillcolor: "rgba(230,159,0,0.13)", line: { width: 1, color: "rgba(230,159,0,0.35)" } });
        annotations.push({ x: x0, xref: "x", y: 0, yref: "paper", yanchor: "bottom", xanchor: "left", text: "▲", hovertext: words.replace(/(.{60}\S*) /g, "$1<br>"), captureevents: true, showarrow: false, name: words, font: { size: 11, color: "#b06f00" } });
      }
      if (time.outages.length) data.push({ type: "scatter", mode: "markers", x: [null], y: [null], name: "GPS outage", hoverinfo: "skip", marker: { symbol: "square", size: 12, color: "rgba(90,103,114,0.25)" } });
    }
    return { data, layout };
  };

  // Plotly by default offers to upload a figure to its maker's server. This disables the upload.
  const CONFIG = {
    responsive: true, displaylogo: false, showSendToCloud: false, plotlyServerURL: "",
    modeBarButtonsToRemove: ["lasso2d", "select2d", "zoomIn2d", "zoomOut2d"],
  };
  let range = whole, isFitted = false;
  const views = new Map();

  // The vertical ranges of a figure over a span: those of all its points in it, and over the whole time the initial ones.
  const fitted = ({ rows }, [from, to]) => Object.fromEntries(rows.map((row, index) => {
    const isIn = (x) => isNumber(x) && x >= from && x <= to;
    const lists = row.series.flatMap((series) => limits(series).map((list) => list.filter((_, i) => isIn(series.x[i]))));
    const isWhole = (from <= whole[0] && to >= whole[1]) || !lists.flat().some(isNumber);
    const shown = isWhole ? firstView(row).shown : extent(lists, row);
    return [`yaxis${index ? index + 1 : ""}.range`, row.reversed ? shown.reverse() : shown];
  }));

  const show = async (view) => {
    const { element, figure } = view;
    const isTime = figure.abscissa === "time";
    if (!view.drawn) {
      view.drawn = true;
      view.range = whole;
      const { data, layout } = describe(figure, element.clientHeight);
      await Plotly.newPlot(element, data, layout, CONFIG);
      // Screen readers read the figure's label instead of its many shapes.
      for (const drawing of document.querySelectorAll("svg.main-svg, #js-plotly-tester")) drawing.setAttribute("aria-hidden", "true");
      if (isTime) {
        element.on("plotly_relayout", (event) => follow(view, event));
        element.on("plotly_clickannotation", ({ annotation }) => {
          const mark = time.marks.find(({ words }) => words === annotation.name);
          if (mark) showSpan(mark.span);
        });
      }
    }
    if (isTime && view.range !== range) {
      view.range = range;
      await Plotly.relayout(element, { "xaxis.range": [...range], ...(isFitted ? fitted(figure, range) : {}) });
    }
  };

  // When one figure's time axis moves, the figures in view follow at once, the others when they come into view.
  const follow = (view, event) => {
    const isReset = event["xaxis.autorange"] === true;
    const [from, to] = isReset ? whole : event["xaxis.range"] ?? [event["xaxis.range[0]"], event["xaxis.range[1]"]];
    if (from === undefined || (!isReset && from === range[0] && to === range[1])) return;
    range = [from, to];
    isFitted = isReset;
    if (!isReset) view.range = range;
    for (const other of views.values()) if (other.inView) show(other);
  };

  const watcher = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      const view = views.get(target);
      view.inView = isIntersecting;
      if (isIntersecting) show(view);
    }
  }, { rootMargin: "500px" });

  const byAnchor = new Map(figures.map((figure) => [figure.anchor, figure]));
  for (const element of document.querySelectorAll("[data-figure]")) {
    views.set(element, { element, figure: byAnchor.get(element.dataset.figure), drawn: false, inView: false });
    watcher.observe(element);
  }
  // Moves to a span, and fits the vertical axes to it.
  const moveTo = (next) => {
    range = next;
    isFitted = true;
    for (const view of views.values()) if (view.inView) show(view);
  };
  const showSpan = ([from, to]) => {
    const room = Math.max(0.5 * (to - from), 0.01 * (whole[1] - whole[0]));
    moveTo([Math.max(from - room, whole[0]), Math.min(to + room, whole[1])]);
  };
  for (const button of document.querySelectorAll("button.show")) {
    button.addEventListener("click", () => {
      showSpan([Number(button.dataset.from), Number(button.dataset.to)]);
      document.querySelector("[data-figure=position]")?.scrollIntoView({ behavior: "smooth" });
    });
  }
  for (const [element, view] of views) {
    if (view.figure.abscissa !== "time") continue;
    element.addEventListener("keydown", (event) => {
      const [from, to] = range;
      const width = to - from;
      const next = {
        ArrowLeft: [from - 0.2 * width, to - 0.2 * width], ArrowRight: [from + 0.2 * width, to + 0.2 * width],
        "+": [from + 0.25 * width, to - 0.25 * width], "=": [from + 0.25 * width, to - 0.25 * width],
        "-": [from - 0.5 * width, to + 0.5 * width], 0: [...whole], Home: [...whole],
      }[event.key];
      if (!next || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      moveTo(next);
    });
  }
  const redraw = (next) => {
    theme = next;
    ROLES = rolesOn(theme);
    for (const view of views.values()) {
      if (!view.drawn) continue;
      Plotly.purge(view.element);
      view.drawn = false;
      if (view.inView) show(view);
    }
  };
  dark.addEventListener("change", () => redraw(dark.matches ? DARK : LIGHT));
  // Print in light colours, regardless of the screen.
  window.addEventListener("beforeprint", () => { document.querySelectorAll("details").forEach((folded) => { folded.open = true; }); if (theme === DARK) redraw(LIGHT); views.forEach(show); });
  window.addEventListener("afterprint", () => { if (dark.matches) redraw(DARK); });
})();
