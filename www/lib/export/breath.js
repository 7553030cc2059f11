/** Lets the page's thread do other things. */
export function breath() {
  return new Promise((done) => setTimeout(done));
}
