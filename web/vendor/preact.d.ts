// Made by web/vendor.mjs.
export { Component, Fragment, createContext, h, render } from "preact";
export { useCallback, useEffect, useId, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
export { batch, computed, effect, signal, untracked, useComputed, useSignal, useSignalEffect } from "@preact/signals";
import { h as element } from "preact";
export type { ComponentChild, ComponentChildren } from "preact";
export type { Signal, ReadonlySignal } from "@preact/signals";
export const html: (strings: TemplateStringsArray, ...values: any[]) => ReturnType<typeof element>;
