// Plans a leg whenever a slider moves: one at a time, the last place of the sliders at the end.
"use strict";
const form = document.getElementById("leg");
const planned = document.getElementById("planned");
let busy = false;
let moved = false;

async function plan() {
  moved = true;
  if (busy) return;
  busy = true;
  planned.setAttribute("aria-busy", "true");
  while (moved) {
    moved = false;
    const query = new URLSearchParams(new FormData(form));
    try {
      const answer = await fetch("/plan/leg?" + query);
      planned.innerHTML = await answer.text();
      history.replaceState(null, "", "/plan?" + query);
    } catch (reason) {
      planned.textContent = "No answer: scdpr show has ended. Start it again, and reload the page.";
    }
  }
  planned.removeAttribute("aria-busy");
  busy = false;
}

form.addEventListener("input", (event) => {
  const shown = form.querySelector('output[for="' + event.target.id + '"]');
  if (shown) shown.textContent = String(Number(event.target.value));
  plan();
});
if ("waits" in planned.dataset) plan();
form.addEventListener("submit", (event) => {
  event.preventDefault();
  plan();
});
