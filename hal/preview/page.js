'use strict';
// Presses the mirror's buttons, shows its status line, and takes the picture up again when the mirror comes back.
const picture = document.getElementById('picture');
const line = document.getElementById('line');
const state = document.getElementById('state');
const status = document.getElementById('status');
const keys = { ArrowRight: 'next', ArrowLeft: 'previous', ArrowUp: 'view', ArrowDown: 'view', s: 'service', S: 'service' };

let lastPresented = -1;
let lastMoved = 0;
let broken = false;

picture.addEventListener('error', () => { broken = true; });

function show(name, text) {
  if (line.dataset.state !== name) line.dataset.state = name;
  if (state.textContent !== text) state.textContent = text;
}

async function look() {
  try {
    const response = await fetch('/status.json', { cache: 'no-store', signal: AbortSignal.timeout(3000) });
    if (!response.ok) throw new Error(String(response.status));
    const mirror = await response.json();
    if (broken) {
      broken = false;
      picture.src = '/stream.mjpg?again=' + Date.now();
    }
    const now = performance.now();
    if (mirror.presented !== lastPresented) lastMoved = now;
    lastPresented = mirror.presented;
    if (now - lastMoved < 2000) show('live', 'Live');
    else show('waiting', 'The picture stands still');
    if (status.textContent !== mirror.status) status.textContent = mirror.status;
  } catch {
    show('lost', 'Connection lost, trying again');
    status.textContent = '';
    broken = true;
  }
  setTimeout(look, 500);
}

async function press(name) {
  const button = document.querySelector(`button[data-button="${name}"]`);
  // The service screen has a key alone: it is for technicians.
  if (button) {
    button.classList.add('pressed');
    setTimeout(() => button.classList.remove('pressed'), 150);
  }
  try {
    await fetch('/button/' + name, { method: 'POST', signal: AbortSignal.timeout(3000) });
  } catch {
    show('lost', 'Connection lost, trying again');
  }
}

for (const button of document.querySelectorAll('button[data-button]')) {
  button.addEventListener('click', () => press(button.dataset.button));
}
document.addEventListener('keydown', (event) => {
  const name = keys[event.key];
  if (!name || event.repeat || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  press(name);
});
look();
