// What the package takes of fflate: deflate for PNG files, and ZIP archives.
export { Zip, ZipPassThrough, unzipSync, unzlibSync, zipSync, zlibSync } from 'fflate';
