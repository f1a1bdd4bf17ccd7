// Uploads one file in parts side by side with tus-js-client: node tus_parallel.mjs ENDPOINT FILE FLIGHT NAME [TOKEN].
import {createReadStream} from 'node:fs';
import {Upload} from 'tus-js-client';

const [endpoint, path, flight, filename, token] = process.argv.slice(2);
const upload = new Upload(createReadStream(path), {
  endpoint,
  parallelUploads: 4,
  headers: token === undefined ? {} : {Authorization: `Bearer ${token}`},
  metadata: {flight, filename},
  retryDelays: null,
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
