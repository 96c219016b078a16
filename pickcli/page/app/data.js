// The page's document: packed in the page, unpacked here.

const INTEGERS = { i1: Int8Array, i2: Int16Array, i4: Int32Array };

/** Reads the document that an element holds: JSON, compressed by gzip, in base64. */
export async function readDocument(element) {
  const stream = new Blob([bytesOf(element.textContent.trim())]).stream().pipeThrough(new DecompressionStream("gzip"));
  return JSON.parse(await new Response(stream).text());
}

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes;
}

/** Rows of numbers from an array that pickcli.files.packed_array.py packed. */
export function unpack(packed) {
  const [n, columns = 1] = packed.shape;
  const steps = new INTEGERS[packed.type](bytesOf(packed.data).buffer);
  const values = new Float64Array(n * columns);
  const sums = new Float64Array(columns);
  for (let i = 0; i < values.length; i++) {
    const column = i % columns;
    sums[column] += steps[i];
    values[i] = sums[column] * packed.unit;
  }
  return { n, columns, values };
}

/** Where a time is between the rows of a table: the row before it, and the share of the way to the next. */
export function placeIn(times, t) {
  const last = times.length - 1;
  if (last <= 0 || t <= times[0]) return [0, 0];
  if (t >= times[last]) return [last - 1, 1];
  let low = 0;
  let high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  return [low, (t - times[low]) / (times[high] - times[low])];
}

/** One row of a table at a time, straight between its rows. */
export function rowAt(times, table, t, out = []) {
  const [i, share] = placeIn(times, t);
  const next = Math.min(i + 1, table.n - 1);
  for (let k = 0; k < table.columns; k++) {
    const a = table.values[i * table.columns + k];
    out[k] = a + (table.values[next * table.columns + k] - a) * share;
  }
  return out;
}
