// A deck: formulas first, then every slide is made to fit its 1280 x 720 pixels, then reveal.js takes over.
(async function () {
  "use strict";
  const WIDTH = 1280, HEIGHT = 720, ROOM = 640, SIZES = [1, 0.92, 0.84], SMALLEST = 0.74;
  const printing = /print-pdf/i.test(location.search);
  const scenes = () => [...document.querySelectorAll(".omx-scene[data-scene]")];

  // In print, WebGL leaves a blank: pictures taken before (OMX_PICTURES) stand in for the scenes.
  if (printing && window.OMX_PICTURES) {
    scenes().forEach((box, i) => {
      const picture = document.createElement("img");
      picture.src = window.OMX_PICTURES[i];
      picture.alt = box.getAttribute("aria-label");
      box.replaceChildren(picture);
      box.removeAttribute("data-scene");
    });
    for (const sliders of document.querySelectorAll(".omx-controls")) sliders.remove();
  }

  await MathJax.startup.promise;
  await MathJax.typesetPromise();
  await Promise.all([...document.images].map((image) => image.decode().catch(() => {})));

  const tall = (section) => Math.max(...[...section.children].map((c) => c.offsetTop + c.offsetHeight), 0);
  // Lines that are too long for the slide get smaller type, by as much as they must.
  function narrow(block) {
    const room = block.matches("table") ? WIDTH - 80 : block.clientWidth;
    const need = block.matches("table") ? block.offsetWidth : block.scrollWidth;
    if (need <= room + 1) return;
    block.style.fontSize = `${parseFloat(getComputedStyle(block).fontSize) * (room / need) * 0.985}px`;
  }

  // Somewhat smaller type, so that the last row can still read it; formulas side by side; then a second slide.
  function fit(section) {
    if (fitPicture(section) || fitText(section)) return;
    if (section.querySelector(".formula + .formula")) {
      section.classList.add("beside");
      if (fitText(section)) return;
    }
    section.style.fontSize = "";
    divide(section);
  }

  function fitText(section) {
    return SIZES.some((size) => {
      section.style.fontSize = `${size}em`;
      return tall(section) <= ROOM;
    });
  }

  // One scene or picture on a slide takes the room that the words leave, if that is enough to see something.
  function fitPicture(section) {
    const pictures = section.querySelectorAll(".omx-scene, img");
    if (pictures.length !== 1) return false;
    for (const size of SIZES) {
      section.style.fontSize = `${size}em`;
      section.style.setProperty("--picture", "0px");
      const beside = pictures[0].closest(".omx-panel")?.offsetHeight ?? 0; // sliders take no room below
      const room = ROOM - tall(section) + beside;
      section.style.setProperty("--picture", `${Math.min(room, 520)}px`);
      if (room >= 300 && tall(section) <= ROOM + 4) return true;
    }
    section.style.removeProperty("--picture");
    return false;
  }

  // Move what does not fit to a second slide that repeats the heading.
  function divide(section) {
    const heading = section.querySelector("h1, h2, h3, .again");
    const notes = section.querySelector("aside");
    const pieces = [...section.children].filter((c) => c !== notes).flatMap(parts);
    const rest = section.cloneNode(false);
    if (heading) rest.append(element("p", "again", heading.textContent));
    section.replaceChildren(...pieces);
    section.style.fontSize = "0.92em";
    const moved = takeFromEnd(section, section);
    const last = section.lastElementChild;
    if (tall(section) > ROOM && last.children.length > 1) {
      moved.unshift(element("div", last.className, ...takeFromEnd(section, last)));
    } else if (moved.length && section.children.length > 1 && /^H\d$/.test(last.lastElementChild?.tagName)) {
      moved.unshift(last);
      last.remove();
    }
    if (notes) section.append(notes);
    if (!moved.length || tall(section) > ROOM) shrink(section);
    if (!moved.length) return;
    rest.append(...moved);
    section.after(rest);
    fit(rest);
  }

  // Take children from the end of `box`, leaving one that counts, until the slide has room.
  function takeFromEnd(section, box) {
    const moved = [];
    const spare = () => [...box.children].filter((c) => !c.matches(".again")).length > 1;
    while (spare() && tall(section) > ROOM) {
      moved.unshift(box.lastElementChild);
      box.lastElementChild.remove();
    }
    return moved;
  }

  function element(tag, className, ...children) {
    const node = document.createElement(tag);
    node.className = className;
    node.append(...children);
    return node;
  }

  // A piece of prose can part between its paragraphs; code and what it shows stay together.
  function parts(piece) {
    if (piece.matches(".fragment") || piece.querySelector(".code") || piece.children.length < 2) return [piece];
    const groups = [];
    for (const child of [...piece.children]) {
      const last = groups.at(-1);
      if (last && /^H\d$/.test(last.lastElementChild.tagName)) { last.append(child); continue; }
      groups.push(element("div", piece.className, child));
    }
    return groups;
  }

  // One piece that is taller than a slide: text shrinks as far as it must, which the build reports.
  function shrink(section) {
    for (let size = SIZES.at(-1); size > 0.3 && tall(section) > ROOM; size -= 0.04) section.style.fontSize = `${size}em`;
    if (parseFloat(section.style.fontSize) < SMALLEST) section.dataset.small = section.style.fontSize;
  }

  const leaves = () => document.querySelectorAll(".slides > section > section");
  const blocks = () => document.querySelectorAll(".slides pre, .slides table, .slides .formula");
  for (const output of document.querySelectorAll(".slides pre.output")) {
    if (output.clientWidth < 0.78 * output.scrollWidth) output.style.whiteSpace = "pre-wrap"; // or its type would be tiny
  }
  for (const section of leaves()) fit(section);
  for (const block of blocks()) narrow(block);
  document.body.classList.remove("measuring");

  await Reveal.initialize({
    width: WIDTH, height: HEIGHT, margin: 0.03, center: false, hash: true, slideNumber: "c/t", transition: "none",
    pdfSeparateFragments: false, plugins: [RevealNotes],
    controlsTutorial: false, overview: true,
  });
  document.body.dataset.ready = "true";
})();
