"use strict";
(() => {
  const light = {
    ink: "#1b1f23", soft: "#57606a", faint: "#8c959f", grid: "#e1e5e9", before: "#D55E00", between: "#CC79A7",
    after: "#0072B2", band: "rgba(0,158,115,0.16)", spread: "rgba(213,94,0,0.14)", middle: "#f2f2f2",
    measured: "rgba(27,31,35,0.38)", paper: "#ffffff",
  };
  const dark = {
    ink: "#e6e9ec", soft: "#a3adb8", faint: "#6b7682", grid: "#2c343d", before: "#F0823A", between: "#E3A1C6",
    after: "#56B4E9", band: "rgba(0,190,140,0.20)", spread: "rgba(240,130,58,0.18)", middle: "#2a3038",
    measured: "rgba(230,233,236,0.42)", paper: "#12161b",
  };
  const darkness = matchMedia("(prefers-color-scheme: dark)");
  let printing = false;
  const theme = () => (darkness.matches && !printing ? dark : light);

  const unpacked = async (id) => {
    const text = document.getElementById(id).textContent;
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  };

  // colours of the page stand in the figures by name
  const coloured = (value, colours) => {
    if (typeof value === "string") return value[0] === "@" ? colours[value.slice(1)] : value;
    if (Array.isArray(value)) {
      const plain = (v) => typeof v === "number" || v === null;
      return plain(value[0]) && plain(value[value.length - 1]) ? value : value.map((v) => coloured(v, colours));
    }
    if (value && typeof value === "object") {
      return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, coloured(v, colours)]));
    }
    return value;
  };

  const dressed = (layout, colours, height) => {
    const full = coloured(layout, colours);
    full.height = height;
    // a screen may be wider than paper
    if (printing) full.width = 640;
    else full.autosize = true;
    full.paper_bgcolor = "rgba(0,0,0,0)";
    full.plot_bgcolor = "rgba(0,0,0,0)";
    full.font = { color: colours.ink, size: 12, family: getComputedStyle(document.body).fontFamily };
    full.margin = { l: 56, r: 12, t: 34, b: 44, ...full.margin };
    full.legend = { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, ...full.legend };
    full.hoverlabel = { bgcolor: colours.paper, bordercolor: colours.faint, font: { color: colours.ink } };
    full.modebar = { color: colours.faint, activecolor: colours.ink, bgcolor: "rgba(0,0,0,0)" };
    for (const key of Object.keys(full)) {
      if (/^[xy]axis\d*$/.test(key)) {
        full[key] = { gridcolor: colours.grid, zerolinecolor: colours.faint, linecolor: colours.faint, ...full[key] };
      }
    }
    return full;
  };

  const settings = {
    responsive: true, displayModeBar: innerWidth < 640 ? false : "hover", displaylogo: false, showSendToCloud: false, showEditInChartStudio: false,
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
  };

  const control = (place, text, element) => {
    let bar = place.previousElementSibling;
    if (!bar || !bar.classList.contains("control")) {
      bar = document.createElement("div");
      bar.className = "control";
      place.before(bar);
    }
    const label = document.createElement("label");
    label.append(text, element);
    bar.append(label);
  };

  const choice = (labels) => {
    const select = document.createElement("select");
    labels.forEach((text, k) => select.append(new Option(text, k)));
    return select;
  };

  const drawViews = (place, views, first) => {
    let shown = first;
    let lit = null;
    // rectangles of the finding that is shown in the arm
    const marks = (view) => (lit !== null && view.marks && view.marks[lit]) || [];
    const draw = () => {
      const colours = theme();
      const view = views[shown];
      const height = Number(place.dataset.height);
      const layout = dressed(view.layout, colours, height);
      const frames = marks(view).map(([x0, x1, y0, y1]) => ({ type: "rect", x0, x1, y0, y1, line: { color: colours.ink, width: 1.5 } }));
      layout.shapes = [...(layout.shapes || []), ...frames];
      return Plotly.react(place, coloured(view.data, colours), layout, settings);
    };
    let select = null;
    if (views.some((view) => view.marks)) {
      document.addEventListener("finding", (event) => {
        lit = event.detail;
        place.dataset.framed = "";
        const given = views.findIndex((view) => view.given && marks(view).length);
        if (given >= 0) shown = given;
        if (select) select.value = shown;
        if (marks(views[shown]).length) {
          place.dataset.framed = lit;
          const closed = place.closest("details");
          if (closed) closed.open = true;
        }
        if (place.offsetParent && place.classList.contains("js-plotly-plot")) draw();
      });
    }
    if (views.length > 1) {
      select = choice(views.map((view) => view.label));
      select.value = shown;
      select.addEventListener("change", () => {
        shown = Number(select.value);
        draw();
      });
      control(place, "Show ", select);
    }
    return draw;
  };

  // a turntable view of the points: turned about the vertical, seen from 20 degrees above
  const drawArm = (place, arm) => {
    const tilt = (20 * Math.PI) / 180;
    let at = 0;
    let turn = (35 * Math.PI) / 180;
    let model = 0;
    let lit = null;
    const seen = ([x, y, z]) => {
      const across = -x * Math.sin(turn) + y * Math.cos(turn);
      const away = x * Math.cos(turn) + y * Math.sin(turn);
      return [across, z * Math.cos(tilt) - away * Math.sin(tilt)];
    };
    const reach = Math.max(0.2, ...arm.points_m.flat().map((p) => Math.hypot(...p))) * 1.12;
    const draw = () => {
      const colours = theme();
      const points = arm.points_m[at];
      const flat = points.map(seen);
      const xs = (list) => list.map((p) => p[0]);
      const ys = (list) => list.map((p) => p[1]);
      const ring = [];
      for (let k = 0; k <= 48; k += 1) {
        const a = (k / 48) * 2 * Math.PI;
        ring.push(seen([reach * 0.85 * Math.cos(a), reach * 0.85 * Math.sin(a), 0]));
      }
      const shadow = points.map(([x, y]) => seen([x, y, 0]));
      const path = arm.points_m.map((p) => seen(p[p.length - 1]));
      const line = (list, name, colour, width, extra) => ({
        type: "scatter", mode: "lines", x: xs(list), y: ys(list), name, hoverinfo: "skip",
        line: { color: colour, width }, showlegend: false, ...extra,
      });
      const joints = arm.joints.map((name, j) => flat[j + 1]);
      const share = arm.shares.length ? arm.shares[model].share : [];
      const data = [
        line(ring, "floor", colours.grid, 1.5),
        line(shadow, "shadow", colours.grid, 5),
        line(path, "path of the tip", colours.faint, 1, { showlegend: true, line: { color: colours.faint, width: 1, dash: "dot" } }),
        line(flat, "links", colours.soft, 6),
      ];
      // one finding, or all of them
      const links = lit === null ? arm.blamed_links : arm.findings[lit].links;
      const ringed = lit === null ? arm.blamed_joints : arm.findings[lit].joints;
      const name = (what) => (lit === null ? `${what} with a finding` : arm.findings[lit].title);
      links.forEach((j, k) => {
        data.push(line([flat[j + 1], flat[j + 2]], name("link"), colours.before, lit === null ? 10 : 16, { showlegend: k === 0 }));
      });
      if (ringed.length) {
        const rings = ringed.map((j) => flat[j + 1]);
        data.push({
          type: "scatter", mode: "markers", x: xs(rings), y: ys(rings), name: name("joint"), hoverinfo: "skip",
          marker: { size: lit === null ? 24 : 32, color: "rgba(0,0,0,0)", line: { color: colours.before, width: lit === null ? 3 : 6 } },
        });
      }
      data.push({
        type: "scatter", mode: "markers", x: xs(joints), y: ys(joints), name: "joints", showlegend: false,
        text: arm.joints.map((name, j) => `${name}<br>unexplained ${share[j] == null ? "-" : (100 * share[j]).toPrecision(3) + " %"}`),
        hovertemplate: "%{text}<extra></extra>",
        marker: {
          size: 15, color: share.map((s) => (s == null ? null : 100 * s)), colorscale: "Cividis", cmin: 0,
          cmax: Math.max(1, ...arm.shares.flatMap((s) => s.share).map((s) => Math.min(100, 100 * (s || 0)))),
          line: { color: colours.ink, width: 1 },
          colorbar: { title: { text: "unexplained [%]", side: "right" }, thickness: 12 },
        },
      });
      const blank = { visible: false, range: [-reach, reach] };
      const layout = dressed({
        hovermode: "closest", xaxis: { ...blank },
        yaxis: { visible: false, range: [-0.4 * reach, 0.95 * reach], scaleanchor: "x" },
      }, colours, Number(place.dataset.height));
      return Plotly.react(place, data, layout, settings);
    };
    const slider = (text, most, value, changed, said) => {
      const input = document.createElement("input");
      Object.assign(input, { type: "range", min: 0, max: most, value });
      const told = document.createElement("output");
      told.textContent = said(Number(value));
      input.addEventListener("input", () => {
        changed(Number(input.value));
        told.textContent = said(Number(input.value));
        draw();
      });
      const track = document.createElement("span");
      track.className = "track";
      track.append(input);
      const both = document.createElement("span");
      both.append(track, " ", told);
      control(place, text, both);
      return input;
    };
    const time = slider("Time ", arm.time_s.length - 1, 0, (v) => { at = v; }, (v) => `${arm.time_s[v].toFixed(2)} s`);
    slider("Turn ", 360, 35, (v) => { turn = (v * Math.PI) / 180; }, (v) => `${v}°`);
    if (arm.shares.length > 1) {
      const select = choice(arm.shares.map((s) => s.label));
      select.addEventListener("change", () => {
        model = Number(select.value);
        draw();
      });
      control(place, "Model ", select);
    }
    if (arm.findings.length) {
      const select = choice(["all", ...arm.findings.map((finding) => finding.title)]);
      const told = document.createElement("p");
      told.className = "legend";
      told.setAttribute("role", "status");
      place.after(told);
      // the times at which a finding acts, below the slider
      const intervals = (finding) => {
        const first = arm.time_s[0];
        const length = arm.time_s[arm.time_s.length - 1] - first || 1;
        const share = (t) => `${Math.min(100, Math.max(0, (100 * (t - first)) / length)).toFixed(1)}%`;
        const colour = theme().before;
        const stops = finding.acts_s.flatMap(([from, to]) => [
          `transparent ${share(from)}`, `${colour} ${share(from)}`, `${colour} ${share(to)}`, `transparent ${share(to)}`,
        ]);
        return `linear-gradient(to right, ${["transparent 0%", ...stops, "transparent 100%"].join(", ")}) bottom / 100% 4px no-repeat`;
      };
      const light = (k) => {
        lit = k;
        select.value = k === null ? 0 : k + 1;
        place.dataset.lit = k === null ? "" : arm.findings[k].title;
        time.parentElement.style.background = "";
        told.textContent = "";
        if (k !== null) {
          const finding = arm.findings[k];
          const parts = [finding.title];
          if (finding.regime) parts.push(`regime: ${finding.regime}`);
          if (finding.acts_s.length) {
            time.parentElement.style.background = intervals(finding);
            parts.push(`acts ${finding.acts_s.map(([from, to]) => `${Math.max(0, from).toFixed(1)} s to ${to.toFixed(1)} s`).join(", ")}`);
          }
          told.textContent = `${parts.join("; ")}.`;
          if (finding.strongest_s !== null) {
            const near = arm.time_s.reduce((best, t, j) => (Math.abs(t - finding.strongest_s) < Math.abs(arm.time_s[best] - finding.strongest_s) ? j : best), 0);
            time.value = near;
            time.dispatchEvent(new Event("input"));
          }
        }
        draw();
        document.dispatchEvent(new CustomEvent("finding", { detail: k }));
      };
      select.addEventListener("change", () => light(Number(select.value) ? Number(select.value) - 1 : null));
      control(place, "Finding ", select);
      for (const button of document.querySelectorAll("button.light")) {
        button.addEventListener("click", () => {
          light(Number(button.dataset.finding));
          place.closest("section").scrollIntoView({ block: "start" });
        });
      }
    }
    return draw;
  };

  const start = async () => {
    const [library, text] = await Promise.all([unpacked("library"), unpacked("figures")]);
    const script = document.createElement("script");
    script.textContent = library;
    document.head.append(script);
    const figures = JSON.parse(text);
    const drawers = new Map();
    const drawn = new Set();
    for (const place of document.querySelectorAll(".chart")) {
      const figure = figures[place.id];
      if (figure) drawers.set(place, figure.skeleton ? drawArm(place, figure.skeleton) : drawViews(place, figure.views, figure.first || 0));
    }
    const draw = (place) => {
      drawn.add(place);
      return drawers.get(place)();
    };
    const watcher = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        if (entry.isIntersecting && !drawn.has(entry.target)) draw(entry.target);
      }
    }, { rootMargin: "400px" });
    for (const place of drawers.keys()) watcher.observe(place);
    const redraw = () => {
      for (const place of drawn) if (place.offsetParent) drawers.get(place)();
    };
    darkness.addEventListener("change", redraw);
    // on paper: everything that is open, in light colours
    addEventListener("beforeprint", () => {
      printing = true;
      for (const place of drawers.keys()) if (place.offsetParent) draw(place);
    });
    addEventListener("afterprint", () => {
      printing = false;
      redraw();
      for (const place of drawn) if (place.offsetParent) Plotly.Plots.resize(place);
    });
    // a link to something closed opens it
    const open = () => {
      const target = location.hash && document.getElementById(location.hash.slice(1));
      const closed = target && target.closest("details");
      if (closed) closed.open = true;
    };
    addEventListener("hashchange", open);
    open();
    document.documentElement.dataset.ready = "true";
  };

  document.getElementById("save").addEventListener("click", () => {
    const blob = new Blob([document.getElementById("result").textContent], { type: "application/json" });
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = "result.json";
    link.click();
    URL.revokeObjectURL(link.href);
  });

  if (typeof DecompressionStream === "undefined") {
    for (const place of document.querySelectorAll(".chart")) {
      place.style.minHeight = 0;
      place.textContent = "This browser cannot unpack the charts: it lacks DecompressionStream (browsers since 2023 have it).";
    }
  } else {
    start();
  }
})();
