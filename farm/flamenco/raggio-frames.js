// An animation on many machines: each task renders some frames; those that are there and whole are not rendered again. Put
// this file into the folder `scripts` beside Flamenco Manager, and give the Manager a variable `raggio` with the program's
// path on each platform.

const JOB_TYPE = {
    label: "raggio: animation",
    description: "Render the frames of an animation",
    settings: [
        { key: "scene", type: "string", subtype: "file_path", required: true,
            description: "Scene or model that raggio reads, where all workers find it" },
        { key: "output", type: "string", subtype: "file_path", required: true,
            description: "Pictures to write, with #### where the number of a frame goes" },
        { key: "frames", type: "string", required: true, default: "1-24",
            description: "Numbers of frames, such as 1-240 or 1-3,5" },
        { key: "chunk_size", type: "int32", default: 1, description: "Frames that a task renders", visible: "submission" },
        { key: "fps", type: "float", default: 24, description: "Frames of a second of the scene's animations" },
        { key: "samples", type: "int32", default: 256, description: "Samples of each pixel" },
        { key: "device", type: "string", default: "auto",
            description: "Devices of a worker, as `raggio render --device` takes them" },
    ],
};

function compileJob(job) {
    const { scene, output, frames, chunk_size, fps, samples, device } = job.settings;
    for (const chunk of frameChunker(frames, chunk_size)) {
        const task = author.Task("frames " + chunk, "misc");
        task.addCommand(author.Command("exec", {
            exe: "{raggio}",
            args: ["render", scene, "--frames", chunk, "--fps", String(fps), "--samples", String(samples),
                "--device", device, "-o", output, "--resume", "--progress", "lines"],
        }));
        job.addTask(task);
    }
}
