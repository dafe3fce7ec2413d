/** What a page carries that is one file: `paint3d/page/single_file.py` packs files of the folder into it. */

/** A file that this page carries, unpacked unless the folder has it packed; null in a page of a folder. */
export function carried(name: string): Promise<ArrayBuffer> | null {
  const block = document.getElementById(`file:${name}`);
  if (block === null) return null;
  const bytes = Uint8Array.from(atob((block.textContent ?? "").trim()), (letter) => letter.charCodeAt(0));
  if (name.endsWith(".gz")) return Promise.resolve(bytes.buffer);
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

/** Start a worker by the address of its script, or by the script of that name that the page carries. */
export async function startWorker(address: string): Promise<Worker> {
  const script = carried(address.slice(address.lastIndexOf("/") + 1));
  if (script === null) return new Worker(address);
  const own = URL.createObjectURL(new Blob([await script], { type: "text/javascript" }));
  const worker = new Worker(own);
  worker.addEventListener("message", () => URL.revokeObjectURL(own), { once: true }); // until then it is being read
  return worker;
}
