// Unpacks the arrays of a page: the inverse of packing.rs.
//
//   bytes = inflate(base64 text)
//   word k of an array = Σ_b 256^b · bytes[at + b·count + k], then the running sum in each column (mod 2^8w)
"use strict";

// The bytes of all arrays, from the text in the page.
async function unpackedBytes(text) {
  if (typeof DecompressionStream === "undefined") {
    throw new Error("this browser is too old; Chrome 80, Firefox 113, Safari 16.4 and newer ones open it");
  }
  const letters = atob(text.trim());
  const bytes = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) bytes[k] = letters.charCodeAt(k);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// The words of an array of 2 or 4 bytes each, as unsigned integers.
function unpackedWords(bytes, place) {
  const { at, count, width, column } = place;
  const words = new Uint32Array(count);
  for (let b = 0; b < width; b++) {
    const plane = at + b * count;
    for (let k = 0; k < count; k++) words[k] |= bytes[plane + k] << (8 * b);
  }
  if (column > 0) {
    const mask = width === 2 ? 0xffff : 0xffffffff;
    for (let k = 0; k < count; k++) {
      if (k % column !== 0) words[k] = (words[k] + words[k - 1]) & mask;
    }
  }
  return words;
}

// An array of single-precision numbers.
function unpackedFloats(bytes, place) {
  return new Float32Array(unpackedWords(bytes, place).buffer);
}

// An array of double-precision numbers, one column.
function unpackedDoubles(bytes, place) {
  const words = new BigUint64Array(place.count);
  let sum = 0n;
  for (let k = 0; k < place.count; k++) {
    let word = 0n;
    for (let b = 7; b >= 0; b--) word = (word << 8n) | BigInt(bytes[place.at + b * place.count + k]);
    sum = BigInt.asUintN(64, sum + word);
    words[k] = sum;
  }
  return new Float64Array(words.buffer);
}
