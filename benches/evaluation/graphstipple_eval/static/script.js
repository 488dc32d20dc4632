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
  const naturalWidth = Number(first.querySelector("img").getAttribute("width")); // known before the picture is there
  const output = document.querySelector(".controls output");
  const view = { scale: 1, x: 0, y: 0 };

  const clamp = (value, least, most) => Math.min(most, Math.max(least, value));

  // At scale 1 a picture fills its pane; at this one, each of its pixels is a pixel of the screen.
  const pixelScale = () => naturalWidth / first.getBoundingClientRect().width / devicePixelRatio;
  const least = () => Math.min(1, pixelScale());

  function show() {
    view.scale = clamp(view.scale, least(), MOST);
    view.x = clamp(view.x, Math.min(1 - view.scale, 0), 0);
    view.y = clamp(view.y, Math.min(1 - view.scale, 0), 0);
    for (const name of ["scale", "x", "y"]) {
      viewer.style.setProperty(`--${name}`, view[name]);
    }
    viewer.classList.toggle("zoomed", view.scale > 1);
    viewer.classList.toggle("pixelated", (view.scale * first.clientWidth) / naturalWidth >= 2);
    output.textContent = `${Math.round((view.scale / pixelScale()) * 100)} %`;
  }

  // Zooms about a point, given in shares of the pane.
  function zoom(wanted, x = 0.5, y = 0.5) {
    const scale = clamp(wanted, least(), MOST);
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
    in: () => zoom(view.scale * STEP),
    out: () => zoom(view.scale / STEP),
    reset: () => zoom(1),
    pixels: () => zoom(pixelScale()),
  };

  const share = (event) => {
    const box = event.currentTarget.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  };

  // The wheel scrolls the page: it zooms with Ctrl, in a picture that is zoomed already, or up when the page was at rest.
  const REST = 400; // milliseconds: longer than between two steps of a wheel that is being turned
  let scrolled = -REST;
  document.addEventListener("scroll", () => {
    scrolled = performance.now();
  });
  // An event that belongs to a scroll of the browser's own cannot be cancelled.
  const zooms = (event) =>
    event.cancelable && (event.ctrlKey || view.scale > 1 || (event.deltaY < 0 && performance.now() - scrolled >= REST));

  for (const pane of viewer.querySelectorAll(".window")) {
    pane.addEventListener(
      "wheel",
      (event) => {
        if (zooms(event)) {
          event.preventDefault();
          const wanted = view.scale * STEP ** clamp(-event.deltaY / 100, -1, 1);
          // Where the pictures fill their panes, the wheel stops.
          zoom(view.scale > 1 ? Math.max(1, wanted) : wanted, ...share(event));
        }
      },
      { passive: false },
    );
    pane.addEventListener("dblclick", (event) => zoom(view.scale * STEP * STEP, ...share(event)));
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
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("select") || (isArrow && view.scale <= 1)) {
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
