% The controller and the input shapers of a scdpr-jax tuning, in the loop of Eq. (24).
%
% Written by scdpr-jax: write it anew rather than change it. SI units and radians. Needs
% MATLAB's Control System Toolbox, or GNU Octave with its package control.

if exist('OCTAVE_VERSION', 'builtin')
    pkg load control
end

%% The controller's numbers
$controller

%% The bare drive: command [V] to angle of the driver pulley [rad], Eq. (24)
$plant
plant = tf([plant_gain], [1, plant_pole, 0]);
sampled_plant = c2d(plant, period, 'zoh');

%% The PD with its filtered backward difference, Eq. (23): error [rad] to command [V]
controller = tf([proportional_gain * (filter_time + period) + derivative_gain, -(proportional_gain * filter_time + derivative_gain)], [filter_time + period, -filter_time], period);

%% The loop; a command comes one sample after its measurement
computing = tf([1], [1, 0], period);
commanding = computing * controller;
loop = commanding * sampled_plant;
closed_loop = feedback(loop, 1);
[gain_margin, phase_margin] = margin(loop); % [1], [deg]

%% Shapers, each for legs that end in its region; the first that contains the end counts
shapers = struct('x', {}, 'y', {}, 'pretension', {}, 'times', {}, 'amplitudes', {});
$shapers

%% An example: a horizontal leg of 1 m in 2 s that ends in the first region
distance = 1; % [m]
leg_time = 2; % [s]
shaper = shapers(1);
samples = ceil((leg_time + shaper.times(end) + 1) / period);
time = period * (0:samples - 1)';
way = min(time / leg_time, 1);
reference = distance * (3 * way .^ 2 - 2 * way .^ 3); % [m]

% Straight between the samples, and the first one held before them.
shaped = zeros(samples, 1); % [m]
for i = 1:numel(shaper.times)
    place = max((0:samples - 1)' - shaper.times(i) / period, 0);
    shaped = shaped + shaper.amplitudes(i) * interp1((0:samples - 1)', reference, place);
end

angle_reference = shaped / effective_radius; % [rad], Eq. (3); the same for both drives
angle = lsim(closed_loop, angle_reference, time); % [rad]
voltage = lsim(feedback(commanding, sampled_plant), angle_reference, time); % [V]
fprintf('margins: %.1f dB, %.1f deg\n', 20 * log10(gain_margin), phase_margin);
fprintf('largest command %.2f V of %.2f V\n', max(abs(voltage)), voltage_limit);

figure;
subplot(2, 1, 1);
plot(time, angle_reference, time, angle);
ylabel('angle [rad]');
legend('shaped reference', 'bare drive');
subplot(2, 1, 2);
plot(time, voltage);
xlabel('time [s]');
ylabel('command [V]');
