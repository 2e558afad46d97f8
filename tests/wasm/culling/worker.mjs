// Culls in a worker of node.
import { pathToFileURL } from 'node:url';
import { parentPort, workerData } from 'node:worker_threads';

const { module, packageFolder, boxes, camera } = workerData;
const { load } = await import(pathToFileURL(`${packageFolder}/js/culling-only.js`));
const sightline = await load({ module });
parentPort.postMessage(sightline.createBoxCuller(boxes).visible(sightline.createView(camera)).slice());
