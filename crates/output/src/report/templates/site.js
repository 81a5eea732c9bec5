"use strict";
// Keeps the served page up to date: asks for it again and replaces the parts that have changed. The server has
// escaped all texts, and what is parsed here runs no script.
(() => {
  const part = (page, id) => page.getElementById(id);
  const note = part(document, "connection");
  const look = async () => {
    try {
      const answer = await fetch("/", { cache: "no-store" });
      if (!answer.ok) throw new Error(answer.statusText);
      const page = new DOMParser().parseFromString(await answer.text(), "text/html");
      for (const id of ["running", "reports"]) {
        const [old, fresh] = [part(document, id), part(page, id)];
        if (!fresh || old.innerHTML === fresh.innerHTML) continue;
        // The keyboard focus stays where it is.
        const at = old.contains(document.activeElement) ? document.activeElement.getAttribute("href") : null;
        old.innerHTML = fresh.innerHTML;
        if (at) [...old.querySelectorAll("a")].find(a => a.getAttribute("href") === at)?.focus();
      }
      note.hidden = true;
    } catch {
      note.hidden = false;
    }
    setTimeout(look, 2000);
  };
  setTimeout(look, 2000);
})();
