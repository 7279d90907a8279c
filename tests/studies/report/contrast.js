// Contrast of each text of a page with what is behind it (WCAG 2.1), as rows of contrast and text.
() => {
  const canvas = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const rgb = (text) => { canvas.clearRect(0, 0, 1, 1); canvas.fillStyle = text; canvas.fillRect(0, 0, 1, 1);
    return [...canvas.getImageData(0, 0, 1, 1).data]; };
  const light = ([r, g, b]) => [r, g, b].map((v) => v / 255).map((v) => v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, k) => sum + v * [0.2126, 0.7152, 0.0722][k], 0);
  const behind = (node) => { for (; node; node = node.parentElement) { const c = rgb(getComputedStyle(node).backgroundColor);
    if (c[3] === 255) return c; } return [255, 255, 255]; };
  const rows = [];
  for (const node of document.querySelectorAll("h1,h2,h3,p,li,td,th,span,b,small,summary,button,output,figcaption,text")) {
    if (![...node.childNodes].some((child) => child.nodeType === 3 && child.textContent.trim()) || node.closest(".cells,.map")) continue;
    const style = getComputedStyle(node), isSvg = node instanceof SVGElement, bar = isSvg && node.previousElementSibling;
    const under = bar && node.classList.contains("on") ? rgb(getComputedStyle(bar).fill) : behind(node);
    const [a, b] = [light(rgb(isSvg ? style.fill : style.color)), light(under)];
    rows.push([(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), node.textContent.slice(0, 40)]);
  }
  return rows;
}
