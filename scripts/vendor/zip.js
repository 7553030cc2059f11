// The parts of fflate that the package uses: deflate for PNG files, and ZIP archives.
export { Zip, ZipPassThrough, unzipSync, unzlibSync, zipSync, zlibSync } from 'fflate';
