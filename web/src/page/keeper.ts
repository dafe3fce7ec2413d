/** The piece in hand, kept in the browser's own storage, so that it is there again after a closed tab. */

import type { OwnFile } from "./own_object";

const NAME = "paint3d";
const STORE = "score"; // parts of a score, in their order
const OBJECT = "object"; // the file that it is painted on, where it is somebody's own

export class Keeper {
  #last: Promise<void> = Promise.resolve();
  #waiting = 0;
  isSound = true; // nothing was refused

  private constructor(private readonly database: IDBDatabase) {}

  /** Open the storage; null where the browser gives none. */
  static async open(): Promise<Keeper | null> {
    try {
      return await new Promise((done, failed) => {
        const asked = indexedDB.open(NAME, 2);
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

  /** Whether all that was given is kept. */
  get isUpToDate(): boolean {
    return this.isSound && this.#waiting === 0;
  }

  /** The score that is kept; "" without one. */
  read(): Promise<string> {
    return new Promise((done, failed) => {
      const asked = this.database.transaction(STORE).objectStore(STORE).getAll() as IDBRequest<string[]>;
      asked.onsuccess = () => done(asked.result.join(""));
      asked.onerror = () => failed(asked.error);
    });
  }

  /** The file that it is painted on; undefined for an object of the page. */
  readObject(): Promise<OwnFile | undefined> {
    return new Promise((done, failed) => {
      const asked = this.database.transaction(OBJECT).objectStore(OBJECT).getAll() as IDBRequest<OwnFile[]>;
      asked.onsuccess = () => done(asked.result[0]);
      asked.onerror = () => failed(asked.error);
    });
  }

  /** Keep another piece from now on, and the file that it is painted on. */
  begin(file: OwnFile | null): void {
    this.#write((store, objects) => {
      store.clear();
      objects.clear();
      if (file !== null) objects.add(file);
    });
  }

  /** Keep a further part of the score. */
  append(text: string): void {
    if (text !== "") this.#write((store) => store.add(text));
  }

  #write(work: (store: IDBObjectStore, objects: IDBObjectStore) => void): void {
    this.#waiting++;
    this.#last = this.#last.then(
      () =>
        new Promise((done) => {
          const over = (isSound: boolean) => (): void => {
            this.isSound &&= isSound;
            this.#waiting--;
            done();
          };
          const transaction = this.database.transaction([STORE, OBJECT], "readwrite");
          work(transaction.objectStore(STORE), transaction.objectStore(OBJECT));
          transaction.oncomplete = over(true);
          transaction.onerror = transaction.onabort = over(false);
        }),
    );
  }
}
