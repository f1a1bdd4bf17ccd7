// The protocol's own server, to compare answers with: node tus_reference.mjs FOLDER. Says its port.
import {FileStore} from '@tus/file-store';
import {Server} from '@tus/server';

const server = new Server({
  path: '/api/v1/uploads',
  datastore: new FileStore({directory: process.argv[2]}),
  maxSize: 4 * 1024 ** 3,
  relativeLocation: true,
});
const listening = server.listen({host: '127.0.0.1', port: 0}, () => console.log(`port ${listening.address().port}`));
