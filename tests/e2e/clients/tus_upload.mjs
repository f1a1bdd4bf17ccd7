// Uploads one file with tus-js-client: node tus_upload.mjs ENDPOINT FILE FLIGHT NAME. Goes on after every break.
import {createReadStream, statSync} from 'node:fs';
import {Upload} from 'tus-js-client';

const [endpoint, path, flight, filename] = process.argv.slice(2);
const upload = new Upload(createReadStream(path), {
  endpoint,
  uploadSize: statSync(path).size,
  chunkSize: 24 * 1024 * 1024,
  metadata: {flight, filename},
  retryDelays: Array(200).fill(250),
  onProgress: (sent) => console.log(`sent ${sent}`),
  onError: (error) => {
    console.error(String(error));
    process.exit(1);
  },
  onSuccess: () => {
    console.log('done');
    process.exit(0);
  },
});
upload.start();
