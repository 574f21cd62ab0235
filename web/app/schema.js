// Questions to the JSON Schema of scenes: which keys and values may stand at a place, and what they mean. No effects.

/** @typedef {any} Schema */
/** @typedef {{ name: string, about: string, insert: string, isRequired: boolean }} Choice */

/** All alternatives of a schema without $ref, oneOf and anyOf. The description of what refers comes first. @param {Schema} root @param {Schema} schema @param {number} [depth] @returns {Schema[]} */
export function alternatives(root, schema, depth = 0) {
  if (!schema || depth > 12) return [];
  const about = schema.description;
  const named = (/** @type {Schema[]} */ list) => (about ? list.map((of) => ({ ...of, about: of.about ?? of.description, description: about })) : list);
  if (schema.$ref) {
    const to = root.$defs?.[schema.$ref.replace("#/$defs/", "")];
    const found = alternatives(root, to, depth + 1);
    return named("default" in schema ? found.map((of) => ({ ...of, default: schema.default })) : found);
  }
  const list = schema.oneOf ?? schema.anyOf;
  if (list) return named(list.flatMap((/** @type {Schema} */ of) => alternatives(root, of, depth + 1)));
  return [schema];
}

/** The alternatives at a place. @param {Schema} root @param {string[]} path keys and indices from the root @returns {Schema[]} */
export function schemasAt(root, path) {
  return path.reduce(
    (schemas, key) =>
      schemas.flatMap((of) => {
        const next = Object.hasOwn(of.properties ?? {}, key) ? of.properties[key] : /^\d+$/.test(key) && of.items ? of.items : typeof of.additionalProperties === "object" ? of.additionalProperties : null;
        return alternatives(root, next);
      }),
    alternatives(root, root),
  );
}

/** @param {Schema} of @returns {string[]} */
const typesOf = (of) => (Array.isArray(of.type) ? of.type : of.type ? [of.type] : of.enum ? [typeof of.enum[0]] : []).filter((/** @type {string} */ type) => type !== "null");

/** Keys for an object that has some already. @param {Schema} root @param {string[]} path @param {string[]} present @returns {Choice[]} */
export function keysAt(root, path, present) {
  const choices = /** @type {Map<string, Choice>} */ (new Map());
  const schemas = schemasAt(root, path);
  for (const of of schemas) {
    const properties = Object.entries(of.properties ?? {});
    // Of a tagged choice ({"sphere": ...} or {"plane": ...}) only one may be there.
    const isTag = properties.length === 1 && schemas.length > 1;
    if (isTag && present.length > 0) continue;
    for (const [name, property] of properties) {
      if (present.includes(name) || choices.has(name)) continue;
      const about = isTag ? (of.about ?? of.description) : alternatives(root, property)[0]?.description;
      choices.set(name, { name, about: about ?? "", insert: template(root, property), isRequired: (of.required ?? []).includes(name) });
    }
  }
  return [...choices.values()];
}

/** Values for a place as JSON. @param {Schema} root @param {string[]} path @param {any} scene the names that it gives */
export function valuesAt(root, path, scene) {
  const choices = /** @type {Map<string, Choice>} */ (new Map());
  const add = (/** @type {any} */ value, /** @type {string} */ about) => {
    const name = JSON.stringify(value);
    if (!choices.has(name)) choices.set(name, { name, about, insert: name, isRequired: false });
  };
  const key = path.at(-1);
  if (key === "material") for (const name of Object.keys(scene?.materials ?? {})) add(name, "a material of this scene");
  if (key === "of") for (const name of Object.keys(scene?.definitions ?? {})) add(name, "a definition of this scene");
  for (const of of schemasAt(root, path)) {
    for (const value of of.enum ?? []) add(value, of.description ?? "");
    if (of.const !== undefined) add(of.const, of.description ?? "");
    if (typesOf(of).includes("boolean")) for (const value of [true, false]) add(value, of.description ?? "");
    if (of.default !== undefined && of.default !== null) add(of.default, "the default");
    if (of.pattern?.startsWith("^#")) add("#cc8844", "a color as sRGB");
    const properties = Object.keys(of.properties ?? {});
    if (properties.length === 1) {
      const insert = `{ ${JSON.stringify(properties[0])}: ${template(root, of.properties[properties[0]])} }`;
      choices.set(properties[0], { name: properties[0], about: of.about ?? of.description ?? "", insert, isRequired: false });
    }
  }
  return [...choices.values()];
}

/** A value to begin with: the default, or the least that is allowed. @param {Schema} root @param {Schema} schema @param {number} [depth] @returns {string} */
export function template(root, schema, depth = 0) {
  const of = alternatives(root, schema)[0];
  if (!of || depth > 4) return "null";
  if (schema.default !== undefined && schema.default !== null) return JSON.stringify(schema.default).replaceAll(",", ", ");
  if (of.enum) return JSON.stringify(of.enum[0]);
  const type = typesOf(of)[0];
  if (type === "object") {
    const entries = (of.required ?? []).map((/** @type {string} */ name) => `${JSON.stringify(name)}: ${template(root, of.properties[name], depth + 1)}`);
    return entries.length > 0 ? `{ ${entries.join(", ")} }` : "{  }";
  }
  if (type === "array") return `[${Array.from({ length: of.minItems ?? 0 }, () => template(root, of.items, depth + 1)).join(", ")}]`;
  if (type === "string") return '""';
  if (type === "boolean") return "true";
  if (type === "number" || type === "integer") return String(of.minimum > 0 ? of.minimum : of.exclusiveMinimum !== undefined ? of.exclusiveMinimum + 1 : (of.minimum ?? 0));
  return "null";
}

/** What a place means: its description, range and default. @param {Schema} root @param {string[]} path @returns {{ title: string, about: string, range: string } | null} */
export function meaningAt(root, path) {
  const schemas = schemasAt(root, path);
  const of = schemas.find(({ description }) => description) ?? schemas[0];
  if (!of || path.length === 0) return null;
  const parts = [];
  if (of.minimum !== undefined && of.maximum !== undefined) parts.push(`${of.minimum} to ${of.maximum}`);
  else if (of.minimum !== undefined) parts.push(`at least ${of.minimum}`);
  else if (of.maximum !== undefined) parts.push(`at most ${of.maximum}`);
  if (of.exclusiveMinimum !== undefined) parts.push(`above ${of.exclusiveMinimum}`);
  if (of.exclusiveMaximum !== undefined) parts.push(`below ${of.exclusiveMaximum}`);
  const values = schemas.flatMap((each) => each.enum ?? []);
  if (values.length > 0) parts.push(values.map((value) => JSON.stringify(value)).join(", "));
  const tags = schemas.flatMap((each) => (Object.keys(each.properties ?? {}).length === 1 ? Object.keys(each.properties) : []));
  if (tags.length > 1) parts.push(`one of ${tags.join(", ")}`);
  if (of.default !== undefined && of.default !== null) parts.push(`default ${JSON.stringify(of.default)}`);
  return { title: path.filter((key) => !/^\d+$/.test(key)).at(-1) ?? "", about: of.description ?? "", range: parts.join(" · ") };
}

/** @param {string[]} path @param {any} root whether a value there is a color */
export const isColor = (root, path) => schemasAt(root, path).some((of) => of.pattern?.startsWith("^#"));
