"use strict";

// Tables: a click on a heading sorts the measured rows, a second one turns the order.
for (const table of document.querySelectorAll("table.sortable")) {
  const body = table.querySelector("tbody.measured");
  const headings = [...table.querySelectorAll("thead tr:last-child th")];
  headings.forEach((heading, column) => {
    heading.querySelector("button").addEventListener("click", () => {
      const ascending = heading.getAttribute("aria-sort") !== "ascending";
      headings.forEach((other) => other.removeAttribute("aria-sort"));
      heading.setAttribute("aria-sort", ascending ? "ascending" : "descending");
      const value = (row) => row.cells[column].dataset.value;
      const rows = [...body.rows].sort((a, b) => {
        if (column === 0) {
          return (ascending ? 1 : -1) * a.cells[0].textContent.localeCompare(b.cells[0].textContent);
        }
        // Rows without a value come last in both orders.
        if (value(a) === "" || value(b) === "") {
          return (value(a) === "") - (value(b) === "");
        }
        const number = (row) => (value(row) === "inf" ? Infinity : Number(value(row)));
        return (ascending ? 1 : -1) * (number(a) === number(b) ? 0 : number(a) - number(b));
      });
      body.append(...rows);
    });
  });
}

// Pictures side by side: one part of the picture, shown in all of them.
const viewer = document.querySelector(".viewer");
if (viewer) {
  const MOST = 64; // scale at which a pixel of a small photo fills a good part of its pane
  const STEP = 1.5;
  const first = viewer.querySelector(".window");
  const image = first.querySelector("img");
  const output = document.querySelector(".controls output");
  const view = { scale: 1, x: 0, y: 0 };

  const clamp = (value, least, most) => Math.min(most, Math.max(least, value));

  function show() {
    view.scale = clamp(view.scale, 1, MOST);
    view.x = clamp(view.x, 1 - view.scale, 0);
    view.y = clamp(view.y, 1 - view.scale, 0);
    for (const name of ["scale", "x", "y"]) {
      viewer.style.setProperty(`--${name}`, view[name]);
    }
    viewer.classList.toggle("pixelated", (view.scale * first.clientWidth) / image.naturalWidth >= 2);
    output.textContent = `${Math.round(view.scale * 100)} %`;
  }

  // Zooms about a point, given in shares of the pane.
  function zoom(factor, x = 0.5, y = 0.5) {
    const scale = clamp(view.scale * factor, 1, MOST);
    view.x = x - ((x - view.x) * scale) / view.scale;
    view.y = y - ((y - view.y) * scale) / view.scale;
    view.scale = scale;
    show();
  }

  function move(x, y) {
    view.x += x;
    view.y += y;
    show();
  }

  const actions = {
    in: () => zoom(STEP),
    out: () => zoom(1 / STEP),
    reset: () => zoom(1 / view.scale),
    pixels: () => zoom(image.naturalWidth / first.clientWidth / devicePixelRatio / view.scale),
  };

  const share = (event) => {
    const box = event.currentTarget.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  };

  for (const pane of viewer.querySelectorAll(".window")) {
    pane.addEventListener(
      "wheel",
      (event) => {
        // The whole picture cannot get smaller: the page scrolls on.
        if (view.scale === 1 && event.deltaY > 0) {
          return;
        }
        event.preventDefault();
        zoom(STEP ** clamp(-event.deltaY / 100, -1, 1), ...share(event));
      },
      { passive: false },
    );
    pane.addEventListener("dblclick", (event) => zoom(STEP * STEP, ...share(event)));
    let last = null;
    pane.addEventListener("pointerdown", (event) => {
      pane.setPointerCapture(event.pointerId);
      last = share(event);
    });
    pane.addEventListener("pointermove", (event) => {
      if (last) {
        const now = share(event);
        move(now[0] - last[0], now[1] - last[1]);
        last = now;
      }
    });
    pane.addEventListener("lostpointercapture", () => {
      last = null;
    });
  }

  for (const button of document.querySelectorAll("[data-zoom]")) {
    button.addEventListener("click", actions[button.dataset.zoom]);
  }
  document.querySelector(".controls select").addEventListener("change", (event) => {
    viewer.style.setProperty("--columns", event.target.value);
    show();
  });

  const keys = {
    "+": actions.in,
    "=": actions.in,
    "-": actions.out,
    0: actions.reset,
    1: actions.pixels,
    ArrowLeft: () => move(0.1, 0),
    ArrowRight: () => move(-0.1, 0),
    ArrowUp: () => move(0, 0.1),
    ArrowDown: () => move(0, -0.1),
  };
  document.addEventListener("keydown", (event) => {
    const isArrow = event.key.startsWith("Arrow");
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("select") || (isArrow && view.scale === 1)) {
      return;
    }
    if (event.key in keys) {
      event.preventDefault();
      keys[event.key]();
    }
  });
  window.addEventListener("resize", show);
  show();
}
