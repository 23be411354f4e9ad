// node read_mcap.js FILE: reads an MCAP file by its own library, as a stream and by its index, and prints one JSON object:
// the messages of each topic, in order, and the schemas, as text (JSON of -0 has no sign once read and written here), and what the two readings say of the file.
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { readFileSync } from "node:fs";

const bytes = readFileSync(process.argv[2]);
const text = (data) => new TextDecoder().decode(data);

// Throws where a checksum or a length is wrong.
function readStream() {
  const reader = new McapStreamReader({ validateCrcs: true });
  reader.append(bytes);
  const topics = {}, channels = new Map();
  for (let record; (record = reader.nextRecord()) !== undefined;) {
    if (record.type === "Channel") channels.set(record.id, record.topic);
    if (record.type === "Message") (topics[channels.get(record.channelId)] ??= []).push(record);
  }
  if (!reader.done()) throw new Error("the stream has no end");
  return topics;
}

async function readIndexed() {
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, size) => new Uint8Array(bytes.subarray(Number(offset), Number(offset + size))),
  };
  return McapIndexedReader.Initialize({ readable });
}

const topics = readStream();
const reader = await readIndexed();
const half = (reader.statistics.messageStartTime + reader.statistics.messageEndTime) / 2n;
let indexed = 0, fromHalf = 0, disordered = 0, last = 0n;
for await (const message of reader.readMessages()) {
  ++indexed;
  if (message.logTime < last) ++disordered;
  last = message.logTime;
}
for await (const message of reader.readMessages({ startTime: half })) if (message.logTime >= half) ++fromHalf;
const messages = {};
for (const [topic, records] of Object.entries(topics))
  messages[topic] = records.map((r) => ({ time_ns: Number(r.logTime), sequence: r.sequence, text: text(r.data) }));
const schemas = {};
for (const schema of reader.schemasById.values())
  schemas[schema.name] = { encoding: schema.encoding, text: text(schema.data) };
console.log(JSON.stringify({
  library: reader.header.library, chunks: reader.chunkIndexes.length, indexed, from_half: fromHalf, disordered,
  counted: Number(reader.statistics.messageCount), messages, schemas,
}));
