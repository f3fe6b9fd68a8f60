// Files that are dropped on the page, or chosen: checked here, so that a wrong one gets a clear answer at once.
import { make, setHidden } from '../ui/dom';
import { size } from '../ui/format';
import type { Actions, PageState } from './state';

const kMagic = 0x46546c67; // "glTF"
const kVersion = 2;
const kHeader_bytes = 12;

// Why this file cannot be loaded; null: it may be sent.
export function objection(name: string, bytes: ArrayBuffer, most_bytes: number): string | null {
  if (!/\.glb$/i.test(name)) return notGlb(name);
  if (bytes.byteLength > most_bytes) return tooLarge(name, bytes.byteLength, most_bytes);
  if (bytes.byteLength < kHeader_bytes) return `${name} is empty or cut off: export it again.`;
  const view = new DataView(bytes);
  if (view.getUint32(0, true) !== kMagic) {
    return `${name} is no .glb, although it is named so: it does not begin with “glTF”. Export it as glTF Binary.`;
  }
  const version = view.getUint32(4, true);
  if (version !== kVersion) return `${name} is glTF ${version}; Omni reads glTF 2: export it again.`;
  const length = view.getUint32(8, true);
  if (length > bytes.byteLength) {
    return `${name} is cut off: it has ${size(bytes.byteLength)} of ${size(length)}. Copy or export it again.`;
  }
  return null;
}

function notGlb(name: string): string {
  if (/\.gltf$/i.test(name)) return `${name}: export it as glTF Binary (.glb), which has everything in one file.`;
  return `${name} is not a .glb file. Export the model as glTF Binary (.glb) and drop that.`;
}

function tooLarge(name: string, bytes: number, most_bytes: number): string {
  return `${name} has ${size(bytes)}; at most ${size(most_bytes)} can be loaded. Reduce its triangles or pictures.`;
}

// The whole window takes files; a veil says so while one is held over it.
export class DropTarget {
  readonly veil = make('div', { class: 'drop-veil', 'aria-hidden': 'true', hidden: true });
  private state: PageState | null = null;

  constructor(private readonly actions: Actions) {
    this.veil.append(make('p', {}, 'Drop the .glb to touch it'));
    addEventListener('dragover', (event) => {
      if (!hasFiles(event)) return;
      event.preventDefault(); // else the browser would leave the page for the file
      if (event.dataTransfer) event.dataTransfer.dropEffect = this.takes() ? 'copy' : 'none';
      setHidden(this.veil, !this.takes());
    });
    addEventListener('dragleave', (event) => {
      if (event.relatedTarget === null) setHidden(this.veil, true);
    });
    addEventListener('drop', (event) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      setHidden(this.veil, true);
      void this.load([...(event.dataTransfer?.files ?? [])]);
    });
  }

  update(state: PageState): void {
    this.state = state;
  }

  async load(files: File[]): Promise<void> {
    const file = files[0];
    if (file === undefined || this.state === null) return;
    if (!this.takes()) {
      this.actions.notify('warning', 'This page cannot load a scene. Start omni try to touch a model of your own.');
      return;
    }
    const most_bytes = this.state.hello.max_file_bytes;
    if (files.length > 1) this.actions.notify('info', `One scene at a time: ${file.name} is loaded.`);
    // Neither a folder nor a huge file is worth reading.
    const early = !/\.glb$/i.test(file.name) ? notGlb(file.name) : null;
    const large = file.size > most_bytes ? tooLarge(file.name, file.size, most_bytes) : null;
    if (early !== null || large !== null) {
      this.actions.notify('error', early ?? large ?? '');
      return;
    }
    let bytes: ArrayBuffer;
    try {
      bytes = await file.arrayBuffer();
    } catch {
      this.actions.notify('error', `${file.name} could not be read. Is it still there, and may the browser read it?`);
      return;
    }
    const why = objection(file.name, bytes, most_bytes);
    if (why !== null) this.actions.notify('error', why);
    else if (!this.actions.drop(file.name, bytes)) this.actions.notify('error', 'Not loaded: there is no connection.');
    else this.actions.notify('info', `${file.name} is being loaded.`);
  }

  private takes(): boolean {
    return this.state !== null && this.state.hello.hand && this.state.hello.control;
  }
}

function hasFiles(event: DragEvent): boolean {
  return event.dataTransfer?.types.includes('Files') === true;
}
