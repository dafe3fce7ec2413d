/** The piece in hand, kept in the browser's own storage, so that it is there again after a closed tab. */

import type { OwnFile } from "./own_object";

const STORE = "score"; // parts of a score, in their order
const OBJECT = "object"; // the file that it is painted on, where it is somebody's own

/** Who keeps a piece, of this page or of its object. */
export interface Keeping {
  /** Whether all that was given is kept. */
  readonly isUpToDate: boolean;
  /** The score that is kept; "" without one. */
  read(): Promise<string>;
  /** The file that it is painted on; undefined for an object of the page. */
  readObject(): Promise<OwnFile | undefined>;
  /** Keep another piece from now on, and the file that it is painted on; nothing at all where that is refused. */
  begin(file: OwnFile | null, text: string): void;
  /** Keep a further part of the score, unless a part before it is missing. */
  append(text: string): void;
}

export class Keeper implements Keeping {
  #last: Promise<void> = Promise.resolve();
  #waiting = 0;
  isSound = true; // nothing of this piece was refused

  private constructor(private readonly database: IDBDatabase) {}

  /** Open the storage of a name; null where the browser gives none. */
  static async open(name: string): Promise<Keeper | null> {
    try {
      return await new Promise((done, failed) => {
        const asked = indexedDB.open(name, 2);
        asked.onupgradeneeded = ({ oldVersion }) => {
          if (oldVersion < 1) asked.result.createObjectStore(STORE, { autoIncrement: true });
          asked.result.createObjectStore(OBJECT, { autoIncrement: true });
        };
        asked.onsuccess = () => done(new Keeper(asked.result));
        asked.onerror = () => failed(asked.error);
        asked.onblocked = () => failed(new Error("the storage is in use"));
      });
    } catch (cause) {
      console.warn("what is painted cannot be kept in this browser:", cause);
      return null;
    }
  }

  get isUpToDate(): boolean {
    return this.isSound && this.#waiting === 0;
  }

  read(): Promise<string> {
    return new Promise((done, failed) => {
      const asked = this.database.transaction(STORE).objectStore(STORE).getAll() as IDBRequest<string[]>;
      asked.onsuccess = () => done(asked.result.join(""));
      asked.onerror = () => failed(asked.error);
    });
  }

  readObject(): Promise<OwnFile | undefined> {
    return new Promise((done, failed) => {
      const asked = this.database.transaction(OBJECT).objectStore(OBJECT).getAll() as IDBRequest<OwnFile[]>;
      asked.onsuccess = () => done(asked.result[0]);
      asked.onerror = () => failed(asked.error);
    });
  }

  begin(file: OwnFile | null, text: string): void {
    const clear = (store: IDBObjectStore, objects: IDBObjectStore): void => {
      store.clear();
      objects.clear();
    };
    this.#queue(async () => {
      try {
        await this.#write((store, objects) => {
          clear(store, objects);
          if (file !== null) objects.add(file);
          store.add(text);
        });
        this.isSound = true;
      } catch (cause) {
        await this.#write(clear); // the piece before is not to go on as this one
        throw cause;
      }
    });
  }

  append(text: string): void {
    if (text === "") return;
    this.#queue(async () => {
      if (this.isSound) await this.#write((store) => store.add(text));
    });
  }

  #queue(work: () => Promise<void>): void {
    this.#waiting++;
    const refused = (cause: unknown): void => {
      this.isSound = false;
      console.warn("what is painted cannot be kept in this browser:", cause);
    };
    this.#last = this.#last.then(work).catch(refused).finally(() => this.#waiting--);
  }

  #write(work: (store: IDBObjectStore, objects: IDBObjectStore) => void): Promise<void> {
    return new Promise((done, failed) => {
      const transaction = this.database.transaction([STORE, OBJECT], "readwrite");
      transaction.oncomplete = () => done();
      transaction.onabort = () => failed(transaction.error);
      work(transaction.objectStore(STORE), transaction.objectStore(OBJECT));
    });
  }
}
