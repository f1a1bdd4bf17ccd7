// Uploads one file with tus-js-client: node tus_upload.mjs ENDPOINT FILE FLIGHT NAME [PARTS [TOKEN]]. In one piece it goes
// on after every break; in PARTS side by side it ends at the first.
import {createReadStream, statSync} from 'node:fs';
import {Upload} from 'tus-js-client';

const [endpoint, path, flight, filename, parts, token] = process.argv.slice(2);
const in_pieces = {parallelUploads: Number(parts), retryDelays: null};
const in_one = {
  uploadSize: statSync(path).size,
  chunkSize: 24 * 1024 * 1024,
  retryDelays: Array(200).fill(250),
  onProgress: (sent) => console.log(`sent ${sent}`),
};
const upload = new Upload(createReadStream(path), {
  endpoint,
  ...(parts === undefined ? in_one : in_pieces),
  headers: token === undefined ? {} : {Authorization: `Bearer ${token}`},
  metadata: {flight, filename},
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
