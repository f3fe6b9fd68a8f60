// What the page remembers until next time. Browsers may refuse storage: then it forgets, and works all the same.

const kPrefix = 'omni.';

export function recall(key: string): string | null {
  try {
    return localStorage.getItem(kPrefix + key);
  } catch {
    return null;
  }
}

export function remember(key: string, value: string): void {
  try {
    localStorage.setItem(kPrefix + key, value);
  } catch {
    // refused or full
  }
}
