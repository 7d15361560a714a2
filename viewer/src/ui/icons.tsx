// Icons as strokes on a grid of 24: one path each, drawn in the colour of the text.

const PATHS = {
  ghost: "M12 3a8 8 0 0 0-8 8v10l3-2 2.5 2 2.5-2 2.5 2 2.5-2 3 2V11a8 8 0 0 0-8-8zM9 11h.01M15 11h.01",
  eye: "M2 12s4-7 10-7 10 7 10 7-4 7-10 7S2 12 2 12zM12 9a3 3 0 1 0 0 6 3 3 0 0 0 0-6z",
  eyeOff:
    "M3 3l18 18M10.6 5.1A9.7 9.7 0 0 1 12 5c6 0 10 7 10 7a17 17 0 0 1-3.3 4M6.5 6.6A17 17 0 0 0 2 12s4 7 10 7a9.6 9.6 0 0 0 5.4-1.6M9.9 9.9a3 3 0 0 0 4.2 4.2",
  isolate:
    "M4 8V5a1 1 0 0 1 1-1h3M16 4h3a1 1 0 0 1 1 1v3M20 16v3a1 1 0 0 1-1 1h-3M8 20H5a1 1 0 0 1-1-1v-3M9 12a3 3 0 1 0 6 0 3 3 0 0 0-6 0z",
  chevron: "M9 6l6 6-6 6",
  undo: "M9 14L4 9l5-5M4 9h10a6 6 0 0 1 0 12h-3",
  redo: "M15 14l5-5-5-5M20 9H10a6 6 0 0 0 0 12h3",
  search: "M11 4a7 7 0 1 0 0 14 7 7 0 0 0 0-14zM20 20l-4-4",
  settings: "M4 7h10M18 7h2M4 17h4M12 17h8M16 4.5v5M10 14.5v5",
  help: "M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18zM9.2 9a3 3 0 0 1 5.8 1c0 2-3 2.5-3 4M12 17.5h.01",
  sun: "M12 8a4 4 0 1 0 0 8 4 4 0 0 0 0-8zM12 2v2M12 20v2M4.9 4.9l1.4 1.4M17.7 17.7l1.4 1.4M2 12h2M20 12h2M4.9 19.1l1.4-1.4M17.7 6.3l1.4-1.4",
  moon: "M20 14.5A8.5 8.5 0 1 1 9.5 4 7 7 0 0 0 20 14.5z",
  fit: "M3 9V4a1 1 0 0 1 1-1h5M15 3h5a1 1 0 0 1 1 1v5M21 15v5a1 1 0 0 1-1 1h-5M9 21H4a1 1 0 0 1-1-1v-5M9 9h6v6H9z",
  home: "M3 11l9-8 9 8M5 9.5V20h5v-6h4v6h5V9.5",
  parallel: "M4 8h11v11H4zM9 3h11v11M4 8l5-5M15 8l5-5M15 19l5-5",
  section: "M4 7l8-4 8 4v10l-8 4-8-4zM3 14.5l18-6",
  box: "M4 7l8-4 8 4v10l-8 4-8-4zM4 7l8 4 8-4M12 11v10",
  measure: "M3 16L16 3l5 5L8 21zM7 12l2 2M10 9l3 3M13 6l2 2",
  camera:
    "M4 8h3l2-3h6l2 3h3a1 1 0 0 1 1 1v10a1 1 0 0 1-1 1H4a1 1 0 0 1-1-1V9a1 1 0 0 1 1-1zM12 10a3.5 3.5 0 1 0 0 7 3.5 3.5 0 0 0 0-7z",
  move: "M12 3v18M3 12h18M12 3L9 6M12 3l3 3M12 21l-3-3M12 21l3-3M3 12l3-3M3 12l3 3M21 12l-3-3M21 12l-3 3",
  turn: "M20 11a8 8 0 1 0-.5 4M20 5v6h-6",
  grip: "M8 12V6a1.5 1.5 0 0 1 3 0v5M11 11V4.5a1.5 1.5 0 0 1 3 0V11M14 11V6a1.5 1.5 0 0 1 3 0v8a7 7 0 0 1-7 7c-3 0-4.5-1.5-6-4.5L2.8 14a1.6 1.6 0 0 1 2.7-1.6L8 15",
  info: "M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18zM12 11v6M12 7.5h.01",
  more: "M5 11a1 1 0 1 0 0 2 1 1 0 0 0 0-2zM12 11a1 1 0 1 0 0 2 1 1 0 0 0 0-2zM19 11a1 1 0 1 0 0 2 1 1 0 0 0 0-2z",
  folder: "M3 7a1 1 0 0 1 1-1h5l2 2h8a1 1 0 0 1 1 1v9a1 1 0 0 1-1 1H4a1 1 0 0 1-1-1z",
  list: "M8 6h12M8 12h12M8 18h12M4 6h.01M4 12h.01M4 18h.01",
  alert: "M12 4L2.5 20h19zM12 10v5M12 17.5h.01",
  plus: "M12 5v14M5 12h14",
  minus: "M5 12h14",
  trash: "M4 7h16M9 7V4h6v3M6 7l1 13h10l1-13M10 11v5M14 11v5",
  flip: "M12 3v18M8 7l-5 5 5 5M16 7l5 5-5 5",
  up: "M12 19V5M6 11l6-6 6 6",
  down: "M12 5v14M6 13l6 6 6-6",
  play: "M7 4l13 8-13 8z",
  pause: "M8 5v14M16 5v14",
  previous: "M18 5L9 12l9 7zM6 5v14",
  next: "M6 5l9 7-9 7zM18 5v14",
  check: "M5 12.5l4.5 4.5L19 7.5",
  download: "M12 3v12M7 11l5 5 5-5M4 20h16",
  close: "M6 6l12 12M18 6L6 18",
  sidebar: "M4 4h16v16H4zM9 4v16",
  panels: "M4 4h16v16H4zM15 4v16",
  explode: "M10 10L4 4M4 4v4M4 4h4M14 14l6 6M20 20v-4M20 20h-4M14 10l6-6M20 4v4M20 4h-4M10 14l-6 6M4 20v-4M4 20h4",
  sound: "M4 9h4l5-4v14l-5-4H4zM17 8a6 6 0 0 1 0 8",
  soundOff: "M4 9h4l5-4v14l-5-4H4zM17 9l5 6M22 9l-5 6",
  command: "M4 6h16M4 12h10M4 18h7",
  spanner: "M15 5.5a5 5 0 0 0-6.5 6.2L3 17.2V21h3.8l5.5-5.5A5 5 0 0 0 18.5 9L15 12l-3-3z",
  back: "M4 12h12a4 4 0 0 1 0 8h-2M4 12l5-5M4 12l5 5",
} as const;

export type IconName = keyof typeof PATHS;

export function Icon({ name, size = 16 }: { name: IconName; size?: number }) {
  return (
    <svg class="icon" viewBox="0 0 24 24" width={size} height={size} aria-hidden="true" focusable="false">
      <path d={PATHS[name]} />
    </svg>
  );
}
