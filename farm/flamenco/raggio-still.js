// One picture on many machines: each task renders a range of samples, and the last adds them up. Put this file into the folder
// `scripts` beside Flamenco Manager, and give the Manager a variable `raggio` with the program's path on each platform.

const JOB_TYPE = {
    label: "raggio: one picture",
    description: "Render ranges of samples of one picture, and add them up",
    settings: [
        { key: "scene", type: "string", subtype: "file_path", required: true,
            description: "Scene or model that raggio reads, where all workers find it" },
        { key: "output", type: "string", subtype: "file_path", required: true,
            description: "Picture to write (.png, .exr or .film). Parts lie in the folder OUTPUT.parts until it is there" },
        { key: "samples", type: "int32", default: 256, description: "Samples of each pixel" },
        { key: "samples_per_task", type: "int32", default: 64,
            description: "Samples that a task takes of each pixel; a few minutes of work are a good size" },
        { key: "device", type: "string", default: "auto",
            description: "Devices of a worker, as `raggio render --device` takes them" },
    ],
};

function compileJob(job) {
    const { scene, output, samples, samples_per_task, device } = job.settings;
    if (samples < 1 || samples_per_task < 1) {
        throw "there should be at least one sample, and one a task";
    }
    const parts = output + ".parts";
    const prepare = author.Task("prepare", "misc");
    prepare.addCommand(author.Command("exec", {
        exe: "mkdir",
        args: ["-p", parts],
    }));
    job.addTask(prepare);

    const merge = author.Task("merge", "misc");
    const films = [];
    for (let first = 0; first < samples; first += samples_per_task) {
        const end = Math.min(first + samples_per_task, samples);
        const film = parts + "/" + first + ".film";
        const task = author.Task("samples " + first + ".." + end, "misc");
        // A task that is tried again goes on from its checkpoint.
        task.addCommand(author.Command("exec", {
            exe: "{raggio}",
            args: ["render", scene, "--samples", first + ".." + end, "--device", device, "-o", film,
                "--checkpoint", parts + "/" + first + ".checkpoint", "--resume", "--progress", "lines"],
        }));
        task.addDependency(prepare);
        merge.addDependency(task);
        job.addTask(task);
        films.push(film);
    }
    merge.addCommand(author.Command("exec", {
        exe: "{raggio}",
        args: ["merge"].concat(films, ["-o", output]),
    }));
    merge.addCommand(author.Command("exec", {
        exe: "rm",
        args: ["-r", parts],
    }));
    job.addTask(merge);
}
