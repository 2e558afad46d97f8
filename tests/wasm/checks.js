// What pages of tests share: checks, which are counted, numbers at random, and ways to the server.

/** The same numbers, 0 to 1, for the same seed: a linear congruence modulo 2^32, whose upper bits count. */
export function randomNumbers(seed) {
  let state = seed >>> 0;
  const next = () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    const upper = state >>> 16;
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return (upper * 2 ** 16 + (state >>> 16)) / 2 ** 32;
  };
  return { next, between: (low, high) => low + (high - low) * next(), below: (count) => Math.floor(count * next()) };
}

export const log = (text) => fetch('/log', { method: 'POST', body: text });

export const counted = { failed: 0, checks: 0 };

export function check(good, text) {
  ++counted.checks;
  if (!good && ++counted.failed <= 20) log(`FAILED: ${text}`);
  return good;
}

/** Sends a canvas's image to the folder of the test. */
export async function keepImage(canvas, name) {
  const blob = await new Promise((resolve) => canvas.toBlob(resolve));
  await fetch(`/image/${name}`, { method: 'POST', body: blob });
}

/** Runs a test's work and sends how it went; `describe` makes the last line. */
export async function report(work, describe) {
  try {
    await work();
  } catch (error) {
    counted.failed = Math.min(counted.failed, 19); // so that this is printed
    check(false, error.stack ?? String(error));
  }
  const { checks, failed } = counted;
  const summary = `${checks} checks, ${failed} failed; ${describe()}`;
  await fetch('/result', { method: 'POST', body: JSON.stringify({ failed, summary }) });
}
