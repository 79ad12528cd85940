// Writes what write_bag.py wrote as OUT.jsonl as an MCAP file: write_mcap.mjs IN.jsonl OUT.mcap none|lz4|zstd
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import { createRequire } from "node:module";
import process from "node:process";
import readline from "node:readline";

const require = createRequire(process.cwd() + "/");  // installed where the test runs
const { McapWriter } = require("@mcap/core");

const [input, output, compression] = process.argv.slice(2);
const file = fs.openSync(output, "w");
let position = 0n;
const compress = (data) => ({
  compression,
  compressedData: new Uint8Array(execFileSync(compression, ["-c", "-q", "-"], { input: data, maxBuffer: 1 << 28 })),
});
const writer = new McapWriter({
  writable: {
    position: () => position,
    write: async (bytes) => {
      fs.writeSync(file, bytes);
      position += BigInt(bytes.length);
    },
  },
  chunkSize: 1 << 20,
  compressChunk: compression === "none" ? undefined : compress,
});
await writer.start({ profile: "ros2", library: "test" });
const channels = new Map();
for await (const line of readline.createInterface({ input: fs.createReadStream(input) })) {
  const { topic, type, t, data } = JSON.parse(line);
  if (!channels.has(topic)) {
    const schemaId = await writer.registerSchema({ name: type, encoding: "ros2msg", data: new Uint8Array() });
    const channel = { schemaId, topic, messageEncoding: "cdr", metadata: new Map() };
    channels.set(topic, await writer.registerChannel(channel));
  }
  await writer.addMessage({
    channelId: channels.get(topic),
    sequence: 0,
    logTime: BigInt(t),
    publishTime: BigInt(t),
    data: new Uint8Array(Buffer.from(data, "base64")),
  });
}
await writer.end();
fs.closeSync(file);
