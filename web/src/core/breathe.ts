/** Let the browser do what waits for it, between two parts of long work. */
export function breathe(): Promise<void> {
  return new Promise((done) => setTimeout(done));
}
