// Draws the diagrams of a page (```mermaid blocks) with the script that the site has. Where one has an error, its text
// stays.
(() => {
  const blocks = document.querySelectorAll("pre.diagram");
  if (blocks.length === 0) return;
  const script = document.createElement("script");
  script.src = new URL("mermaid.min.js", document.currentScript.src);
  script.onload = async () => {
    mermaid.initialize({startOnLoad: false, theme: "neutral", fontFamily: "inherit"});
    for (const [i, block] of blocks.entries()) {
      const {svg} = await mermaid.render(`diagram_${i}`, block.textContent);
      const drawing = document.createElement("div");
      drawing.className = "diagram";
      drawing.innerHTML = svg;
      const image = drawing.querySelector("svg");
      image.style.minWidth = `${0.75 * image.viewBox.baseVal.width}px`;  // a wide one scrolls: its text stays legible
      block.replaceWith(drawing);
    }
  };
  document.head.append(script);
})();
